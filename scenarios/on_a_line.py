"""Balls on a line that collide one pair at a time: the exact sequence of impacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.head_on_collision import after_collision
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Truth

Number = TypeVar("Number")  # float, or Fraction for the exact sequence


class Impact(NamedTuple, Generic[Number]):
    """State of the line just after a pair has collided."""

    time: Number  # [s]
    pair: int  # ball `pair` struck ball `pair` + 1
    places: tuple[Number, ...]  # of the balls as points [m]
    velocities: tuple[Number, ...]  # [m/s]


def balls_on_a_line(
    radius: float, masses: Sequence[float], places: Sequence[float], velocities: Sequence[float]
) -> tuple[Body, ...]:
    """Balls of one `radius` [m] along x whose places as points, with the diameters taken out, are `places` [m]."""
    rows = enumerate(zip(masses, places, velocities, strict=True))
    return tuple(
        Body(f"ball-{i + 1}", Sphere(radius), m, (x + 2.0 * radius * i, 0.0, 0.0), velocity=(v, 0.0, 0.0))
        for i, (m, x, v) in rows
    )


def travel(start: Sequence[float], sequence: Sequence[Impact[float]]) -> float:
    """Sum over all impacts of the larger change of velocity, from the velocities `start` on [m/s]."""
    velocities = [tuple(start), *(i.velocities for i in sequence)]
    return sum(max(abs(b - a) for a, b in zip(u, v, strict=True)) for u, v in pairwise(velocities))


def impacts_in_turn(
    masses: Sequence[Number],
    places: Sequence[Number],
    velocities: Sequence[Number],
    e: Number,
    until: float = math.inf,
    most: int = 10_000,
) -> list[Impact[Number]]:
    """Every impact up to the time `until` [s], at most `most` of them, one after the other.

    Parameters
    ----------
    masses : [kg]
    places : increasing, of the balls as points: with the diameters taken out of the line [m]
    velocities : [m/s]
    e : restitution

    Rational numbers give a rational sequence.  Where impacts accumulate, the list ends as soon as
    rounding cannot part one from the next.
    """
    x, v, now, found = list(places), list(velocities), 0 * e, []
    while len(found) < most:
        due = [((x[i + 1] - x[i]) / (v[i] - v[i + 1]), i) for i in range(len(x) - 1) if v[i] > v[i + 1]]
        if not due:
            break
        wait, i = min(due)
        if now + wait > until or (found and now + wait <= now and i == found[-1].pair):
            break
        x, now = [p + s * wait for p, s in zip(x, v, strict=True)], now + wait
        x[i + 1] = x[i]
        v[i], v[i + 1] = after_collision(masses[i], masses[i + 1], v[i], v[i + 1], e)
        found.append(Impact(now, i, tuple(x), tuple(v)))
    return found


def between_impacts(scene: Scene, radius: float, sequence: Sequence[Impact[float]]) -> Truth:
    """Uniform motion of the moving bodies of `scene`, balls of one `radius` [m] in order along x, between impacts."""
    start, rows = scene.start(), list(scene.moving)
    shift = 2.0 * radius * np.arange(len(rows))
    times = np.array([0.0, *(i.time for i in sequence)])
    places = np.array([start.x[rows, 0] - shift, *(i.places for i in sequence)])
    speeds = np.array([start.v[rows, 0], *(i.velocities for i in sequence)])
    height = start.x[rows[0], 2]

    def truth(t: np.ndarray) -> Trajectory:
        n = np.searchsorted(times, t, side="right") - 1
        x = places[n] + (t - times[n])[:, None] * speeds[n] + shift
        named = enumerate(scene.names[i] for i in rows)
        return trajectory(
            scene, t, {name: Motion(vectors(t, x=x[:, k], z=height), vectors(t, x=speeds[n, k])) for k, name in named}
        )

    return truth
