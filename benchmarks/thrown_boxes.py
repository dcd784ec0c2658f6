"""A box thrown on a floor a hundred times, with and without friction: does it come to proven rest, and soundly?"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.row import Figure, Row
from comparisons.energy import mechanical_energy
from comparisons.gap import Pose, gap
from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import matrix, normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from reference_impl.errors import Stalled
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin
from reference_impl.world import STILL, World

RESTITUTIONS = (0.0, 0.3, 0.5, 0.7, 0.9)
CASES = ((0.0, "newton"), (0.5, "newton"), (0.5, "energetic"))  # friction, law of restitution; the first two by default
EACH = 10  # boxes of every case and coefficient of restitution
LIMIT = 30.0  # [s] of simulated time, by which every box must lie
SAMPLING = 0.02  # [s]
PATIENCE = 10.0  # processor time of one box [s]
WARMING = 120.0  # of the first ones, for which everything is compiled [s]


@dataclass(frozen=True)
class Thrown:
    """What became of one box."""

    e: float
    mu: float
    law: str  # of restitution
    rests: bool
    rise: float  # greatest rise of energy from sample to sample, over the energy at the start
    gap: float  # deepest overlap at a sample, by the house's own geometry [m]
    simulated: float  # [s]
    seconds: float  # processor time [s]
    trouble: str  # what the engine said when it gave up


def scene(seed: int, e: float, mu: float) -> Scene:
    """A box of random edges with a random attitude, velocity and spin, a metre above a floor.

    A smooth floor takes neither velocity along it nor angular momentum about its normal: without friction the box has
    neither, or it would glide for ever.
    """
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.2, 0.6, 3)
    attitude, velocity, spin = normalised(rng.normal(size=4)), rng.normal(size=3), 5.0 * rng.normal(size=3)
    box = Body("box", Box(tuple(size)), 1.0, (0.0, 0.0, 1.0), tuple(attitude), tuple(velocity), tuple(spin))
    if not mu:
        turn = matrix(attitude)
        inertia = turn @ box.inertia_tensor @ turn.T
        spin = np.linalg.solve(inertia, (inertia @ spin) * (1.0, 1.0, 0.0))
        box = replace(box, velocity=(0.0, 0.0, float(velocity[2])), angular_velocity=tuple(spin.tolist()))
    effects = (Gravity(), Rotation(), Restitution(e), Resting(), *((Friction(mu),) if mu else ()))
    return Scene((Body("floor", HalfSpace()), box), effects)


def thrown(seed: int, e: float, mu: float, law: str = "newton", patience: float = PATIENCE) -> Thrown:
    """One box, until it rests, time is up, or `patience` [s] of processor time."""
    one = scene(seed, e, mu)
    world = begin(one, Settings(restitution=law))
    states, trouble = [world.state()], ""
    begun = time.process_time()
    try:
        while not rests(world) and world.t < LIMIT and time.process_time() - begun < patience:
            advance(world, SAMPLING)
            states.append(world.state())
    except Stalled as error:
        trouble = str(error)
    seconds = time.process_time() - begun
    path = Trajectory.of(states)
    energy = mechanical_energy(one, path)
    floor, box = (Pose(path.x[:, i], path.q[:, i]) for i in range(2))
    return Thrown(
        e,
        mu,
        law,
        rests(world),
        float(np.diff(energy).max(initial=0.0)) / float(energy[0]),
        float(np.min(gap(one.bodies[1].shape, one.bodies[0].shape, box, floor))),
        world.t,
        seconds,
        trouble or ("" if rests(world) else f"still moving at {world.t:.3g} s"),
    )


def rests(world: World) -> bool:
    """Whether every moving body has come to proven rest."""
    return all(world.mode[i] == STILL for i in world.scene.moving)


def measure(tiny: bool = False) -> Row:
    """Ten boxes for every coefficient of restitution: smooth, and rough by two laws of restitution."""
    coefficients = RESTITUTIONS[:1] if tiny else RESTITUTIONS
    each, patience = (1, 1.0) if tiny else (EACH, PATIENCE)
    for mu, law in CASES:  # compiled before the clock runs
        thrown(0, RESTITUTIONS[-1], mu, law, WARMING)
    boxes = {
        case: [thrown(seed, e, *case, patience) for e in coefficients for seed in range(each)] for case in CASES
    }  # fmt: skip
    every = [box for some in boxes.values() for box in some]
    costs = ", ".join(
        f"{sum(b.simulated for b in some) / sum(b.seconds for b in some):.2g} ({_called(*case)})"
        for case, some in boxes.items()
    )
    return Row(
        name="thrown-boxes",
        subject=f"{len(every)} boxes thrown, e from 0 to {coefficients[-1]:g}, with and without friction",
        figures=(
            Figure("come to proven rest", sum(b.rests for b in every), len(every), at_least=True),
            *(
                Figure(f"{_called(*case)}: energy, greatest rise, relative", max(b.rise for b in some), 1e-9)
                for case, some in boxes.items()
            ),
            Figure("overlap at a sample, deepest", max(0.0, *(-b.gap for b in every)), 1e-11, "m"),
        ),
        how=f"sampled every {SAMPLING:g} s until the engine proves rest, at most {LIMIT:g} s; energy from sample to "
        "sample and overlap by the house's own yardsticks; friction 0.5; simulated seconds per second of processor "
        "time: "
        f"{costs}",
        missed="; ".join(
            [f"e = {b.e:g}, {_called(b.mu, b.law)}: {b.trouble}" for b in every if b.trouble]
            or ["Newton's law and friction together create energy at eccentric impacts; Stronge's law does not"]
        ),
    )


def _called(mu: float, law: str) -> str:
    """A case in words."""
    return f"rough, restitution {law}" if mu else "smooth"
