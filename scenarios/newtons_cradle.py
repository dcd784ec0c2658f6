"""Newton's cradle, cut loose: balls in a line, with gaps and without."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import STEP, converged, first_order, rounding

COUNT = 5
RADIUS, GAP, RUN_UP = 0.0625, 1e-4, 0.30037  # [m]; the radius is a binary fraction: touching is a gap of 0 bit by bit
SPEED = 1.0  # [m/s]


def row(launched: int, gap: float) -> Scene:
    """Five equal elastic balls along x, the first `launched` of them coming in as one."""
    bodies = []
    for i in range(COUNT):
        x = i * (2.0 * RADIUS + gap)
        moving = i < launched
        bodies.append(
            Body(
                f"ball-{i + 1}",
                Sphere(RADIUS),
                mass=1.0,
                position=(x - RUN_UP if moving else x, 0.0, 0.0),
                velocity=(SPEED if moving else 0.0, 0.0, 0.0),
            )
        )
    return Scene(tuple(bodies), (Restitution(1.0),))


def swapping(scene: Scene) -> Truth:
    """Equal elastic balls on a line: they swap velocities, so as points they pass through each other.

    With the diameters taken out of the line, the i-th ball is at any time the i-th of the free points.
    """
    start, shift = scene.start(), 2.0 * RADIUS * np.arange(COUNT)
    points, speeds = start.x[:, 0] - shift, start.v[:, 0]

    def truth(t: np.ndarray) -> Trajectory:
        places = points + t[:, None] * speeds
        # at the instant of a meeting the faster point counts as already ahead
        rank = np.lexsort((np.broadcast_to(speeds, places.shape), places), axis=-1)
        x, v = np.take_along_axis(places, rank, -1) + shift, speeds[rank]
        balls = enumerate(scene.names)
        return trajectory(scene, t, {name: Motion(vectors(t, x=x[:, i]), vectors(t, x=v[:, i])) for i, name in balls})

    return truth


@scenario(
    tags=("impact", "chain"),
    suites=("smoke", "standard"),
    variants=({}, {"launched": 2}, {"launched": 3}),
    ranges={"launched": (1, 4)},
)
def newtons_cradle(launched: int = 1) -> Scenario:
    """One, two or three of five equal balls strike the others, which stand 0.1 mm apart.

    With gaps, however small, every impact is between two balls, equal balls swap velocities, and as
    many balls leave as came.  Several impacts fall into one time step, which is the difficulty.
    """
    scene = row(launched, GAP)
    points = scene.start().x[:, 0] - 2.0 * RADIUS * np.arange(COUNT)
    meetings = [float(points[j] - points[i]) / SPEED for i in range(launched) for j in range(launched, COUNT)]
    chain = (COUNT - launched) * SPEED * STEP
    return Scenario(
        scene=scene,
        duration=1.0,
        sampling=0.01,
        truth=swapping(scene),
        checks=(
            first_order("position error", chain, "m", "v h for each ball the push goes through, seen a step late each"),
            converged("velocity error", SPEED, "the approach speed in m/s"),
            rounding("linear momentum error", "an impulse acts on both balls alike"),
            converged("energy error", 1.0, "the energy, as a ratio"),
        ),
        source="equal masses swap velocities; Herrmann and Seitz, Am. J. Phys. 50 (1982) 977",
        about=(Restitution,),
        events=tuple(sorted(meetings)),
        guard=2.0 * len(meetings) * STEP,
    )


@scenario(tags=("impact", "simultaneous"))
def touching_cradle() -> Scenario:
    """One of five equal balls strikes the other four, which touch: what happens depends on the impact law.

    Rigid-body mechanics does not decide this scene.  Solving all contacts at once (Baraff 1989,
    Moreau) throws the first ball back at 3/5 of its speed; one contact after the other, as in a real
    cradle, sends off the last ball alone; engines that solve in part at once produce a third answer.
    The law is named, not marked.  Momentum and energy are marked, since every one of them keeps both.
    """
    final = {
        "sequential": (0.0, 0.0, 0.0, 0.0, 1.0),
        "simultaneous": (-0.6, 0.4, 0.4, 0.4, 0.4),
        "two-group": (-1.0 / 3.0, 0.0, 0.0, 2.0 / 3.0, 2.0 / 3.0),
    }
    return Scenario(
        scene=row(1, 0.0),
        duration=1.0,
        sampling=0.01,
        checks=(
            rounding("linear momentum error", "an impulse acts on both balls alike"),
            converged("energy error", 1.0, "the energy, as a ratio"),
        ),
        source="Baraff, SIGGRAPH 1989; Glocker, Set-Valued Force Laws, ch. 6",
        about=(Restitution,),
        events=(RUN_UP / SPEED,),
        guard=2.0 * COUNT * STEP,
        laws={law: tuple((SPEED * v, 0.0, 0.0) for v in velocities) for law, velocities in final.items()},
    )
