"""A block slides on a plank that slides on a smooth floor."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Force, Friction, Gravity, Resting
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, converged, first_order

BLOCK, PLANK = (0.25, 0.25, 0.125), (8.0, 1.0, 0.25)  # [m]; binary fractions: they touch bit by bit
LIGHT, HEAVY = 2.0, 5.0  # [kg]
MU = 0.25


def bodies(speed: float) -> tuple[Body, Body, Body]:
    """Floor, plank and block; the block starts at `speed` [m/s]."""
    low, high = 0.5 * PLANK[2], PLANK[2] + 0.5 * BLOCK[2]
    plank = Body("plank", Box(PLANK), HEAVY, (0.0, 0.0, low))
    return Body("floor", HalfSpace()), plank, Body("block", Box(BLOCK), LIGHT, (0.0, 0.0, high), velocity=(speed, 0, 0))


def smooth_floor(mu: float) -> Friction:
    """Friction `mu` between block and plank, none with the floor."""
    return Friction(mu, {("floor", "plank"): 0.0, ("floor", "block"): 0.0})


def together(speed: float, mu: float) -> tuple[float, float, float]:
    """Common velocity [m/s], the time until then [s] and the way the block has slid on the plank [m]."""
    time = HEAVY * speed / (mu * GRAVITY * (LIGHT + HEAVY))
    return LIGHT * speed / (LIGHT + HEAVY), time, 0.5 * speed * time


def friction_checks(step: float, duration: float) -> tuple[Check, ...]:
    """What is demanded where friction, or a push, changes velocities by `step` [m/s] in one step of time."""
    return (
        first_order("position error", step * duration, "m", "a h t: a force sets in, or ends, up to a step late"),
        first_order("velocity error", step, "m/s", "a h: what friction or a push changes in one step"),
    )


@scenario(
    tags=("friction", "resting", "box"),
    suites=(),
    variants=({}, {"mu": 0.5}),
    ranges={"mu": (0.01, 10.0), "speed": (0.1, 5.0)},
)
def block_on_plank(mu: float = MU, speed: float = 3.0) -> Scenario:
    """A block at 3 m/s slides onto a plank at rest on a smooth floor and takes it along.

    Friction brakes the one and drives the other until both move alike; momentum is kept all the way.  How
    long that takes depends on friction, where they end up does not.
    """
    floor, plank, block = bodies(speed)
    scene = Scene((floor, plank, block), (Gravity(), smooth_floor(mu), Resting()))
    common, grips, _ = together(speed, mu)

    def truth(t: np.ndarray) -> Trajectory:
        s, rest = np.minimum(t, grips), np.maximum(t - grips, 0.0)
        motions = {}
        for body, start, drag in ((plank, 0.0, LIGHT / HEAVY * mu * GRAVITY), (block, speed, -mu * GRAVITY)):
            x = vectors(t, x=start * s + 0.5 * drag * s**2 + common * rest, z=body.position[2])
            motions[body.name] = Motion(x, vectors(t, x=start + drag * s))
        return trajectory(scene, t, motions)

    duration = round(grips + 0.3, 2)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=(
            *friction_checks(mu * GRAVITY * STEP, duration),
            converged("linear momentum error", 1.0, "the momentum, as a ratio"),
        ),
        source="v = m v₀/(m + M) after t = M v₀/(µ g (m + M)); Kleppner and Kolenkow, Mechanics, ch. 4",
        about=(Gravity, Friction, Resting),
        events=(grips,),
    )


def driven(pull: float, until: float, mu: float) -> tuple[float, float]:
    """When a block sticks to a plank driven by `pull` [m/s2] for `until` [s], and how far it has slipped then [m]."""
    grips = pull * until / (mu * GRAVITY)
    return grips, 0.5 * pull * until * (grips - until)


@scenario(
    tags=("friction", "resting", "box"),
    suites=(),
    variants=({}, {"pull": 2.0}),
    ranges={"pull": (0.1, 20.0)},
)
def driven_plank(pull: float = 4.0) -> Scenario:
    """A plank is set in motion by 4 m/s² for 1.5 s and then kept at its speed; a block lies on it.

    Friction can give the block 2.94 m/s² at most.  Below that it goes along; above, it slips back 1.6 m
    and catches up when the plank has long stopped accelerating.  The push on the plank is a force.
    """
    mu, until = 0.3, 1.5
    floor, plank, block = bodies(0.0)
    slips = pull > mu * GRAVITY
    grips = driven(pull, until, mu)[0] if slips else until
    rub = LIGHT * min(mu * GRAVITY, pull)
    pushes = [Force("plank", (HEAVY * pull + rub, 0.0, 0.0), end=until)]
    pushes += [Force("plank", (rub, 0.0, 0.0), start=until, end=grips)] if slips else []
    scene = Scene((floor, plank, block), (Gravity(), smooth_floor(mu), Resting(), *pushes))

    def truth(t: np.ndarray) -> Trajectory:
        motions = {}
        for body, gain, end in ((plank, pull, until), (block, rub / LIGHT, grips)):
            s, rest = np.minimum(t, end), np.maximum(t - end, 0.0)
            x = vectors(t, x=0.5 * gain * s**2 + gain * end * rest, z=body.position[2])
            motions[body.name] = Motion(x, vectors(t, x=gain * s))
        return trajectory(scene, t, motions)

    duration = round(grips + 0.5, 2)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=friction_checks((pull + mu * GRAVITY) * STEP, duration),
        source="the block sticks if a <= µ g, else it is carried by µ g until the speeds meet: Coulomb friction",
        about=(Gravity, Friction, Resting, Force),
        events=tuple({until, grips}),
    )
