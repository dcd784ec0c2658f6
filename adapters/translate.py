"""What adapters of foreign engines translate alike: versions, import noise, pair coefficients, the time-step ladder."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as distribution_version
from typing import NamedTuple

import numpy as np

from adapters.engine import Refusal
from mechanics.arrays import Quat
from mechanics.effects import Hinge, PairEffect, Restitution, Rod
from mechanics.rotation import IDENTITY, normalised, rotate
from mechanics.scene import Scene

TIME_STEPS = tuple(1.0 / (60 * 2**k) for k in range(9))  # 1/60 s halved down to 1/15360 s


@cache
def installed_version(module: str, *distributions: str) -> str:
    """Version of the installed distribution that brings `module`: of that name, or one of `distributions`.

    Raises
    ------
    ModuleNotFoundError
        If none is installed; its `name` is the module.
    """
    for name in (module, *distributions):
        try:
            return distribution_version(name)
        except PackageNotFoundError:
            continue
    raise ModuleNotFoundError(f"{module} is not installed", name=module)


@contextmanager
def muted() -> Iterator[None]:
    """Send what C code writes to stdout and stderr to nowhere, for the time of an import that chats."""
    kept = os.dup(1), os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        yield
    finally:
        for fd, original in zip((1, 2), kept, strict=True):
            os.dup2(original, fd)
            os.close(original)
        os.close(nowhere)


def anchor_speed(scene: Scene, hinge: Hinge) -> float:
    """Speed at which the two bodies of a hinge part at its point at the start [m/s]; 0 if it begins unviolated."""
    velocities = []
    for name in (hinge.a, hinge.b):
        body = scene.body(name)
        arm = np.subtract(hinge.point, body.position)
        velocities.append(np.array(body.velocity) + np.cross(body.angular_velocity, arm))
    return float(np.linalg.norm(velocities[0] - velocities[1]))


def world_anchor(scene: Scene, name: str, anchor: Sequence[float]) -> np.ndarray:
    """Place of a body-fixed `anchor` at the start, world frame [m]."""
    body = scene.body(name)
    return np.array(body.position) + rotate(np.array(body.orientation), np.array(anchor))


def shortest(start: np.ndarray, end: np.ndarray) -> Quat:
    """The shortest rotation that carries the unit vector `start` into the unit vector `end`.

    By half the way between the two and without trigonometry: of a quarter turn both parts are then
    equal bit by bit, and the difference of their squares, which is a component of what an engine makes
    of it, is zero.  Balls that strike a wall squarely are otherwise sent off their line by rounding,
    which every further collision of theirs makes larger.
    """
    turn, cosine = np.cross(start, end), float(start @ end)
    sine = float(np.linalg.norm(turn))
    if sine < 1e-12:
        across = np.eye(3)[int(np.argmin(np.abs(start)))]
        return np.array(IDENTITY) if cosine > 0.0 else normalised(np.array([0.0, *np.cross(start, across)]))
    # of an angle a: cot(a/2) is both (1 + cos a)/sin a and sin a/(1 - cos a), one of them without cancellation
    half = (1.0 + cosine) / sine if cosine >= 0.0 else sine / (1.0 - cosine)
    return normalised(np.array([half, *(turn / sine)]))


def joined(scene: Scene) -> tuple[tuple[str, str], ...]:
    """Names of the pairs that a Rod or Hinge joins and that therefore do not touch."""
    return tuple((e.a, e.b) for kind in (Rod, Hinge) for e in scene.all(kind))


def rests_only(scene: Scene) -> bool:
    """Whether bodies touch without ever colliding: Restitution is not declared.

    Engines then may correct positions through velocities, which holds stacks better than any
    correction beside them, because no bounce is there to be falsified.
    """
    return scene.touching and Restitution not in scene.needs


class _Term(NamedTuple):
    """Factor of a body as value · x^power, where x is the unknown factor of its component's root."""

    value: float
    power: int


def factors(scene: Scene, effect: PairEffect) -> tuple[float, ...]:
    """Per-body factors whose products are the pair coefficients: aᵢ aⱼ = cᵢⱼ for all pairs that may touch.

    Engines that multiply the coefficients of two bodies are given these.  Fixed bodies get 1 where
    there is a choice, so that one ball on one floor carries its coefficient unchanged.

    Raises
    ------
    Refusal
        If no such factors exist, naming a pair that does not fit.
    """
    if not effect.between and not joined(scene) and len(scene.moving) > 1 and len(scene.bodies) > 2:
        # any two moving bodies and a third one touch each other: only equal factors give all three the same product
        return (math.sqrt(effect.coefficient),) * len(scene.bodies)
    wanted = {(i, j): effect.of(scene.names[i], scene.names[j]) for i, j in scene.pairs()}
    positive: dict[int, list[int]] = {i: [] for i in range(len(scene.bodies))}
    for (i, j), value in wanted.items():
        if value > 0.0:
            positive[i].append(j)
            positive[j].append(i)
    found = [0.0] * len(scene.bodies)
    seen: set[int] = set()
    for root in sorted(positive, key=lambda i: not scene.bodies[i].fixed):
        if root not in seen and positive[root]:
            _solve_component(root, wanted, positive, found)
            seen |= _reach(root, positive)
    for (i, j), value in wanted.items():
        if abs(found[i] * found[j] - value) > 1e-12 * max(1.0, value):
            raise _unfit(scene, effect, i, j)
    return tuple(found)


def _reach(root: int, edges: dict[int, list[int]]) -> set[int]:
    reached, front = {root}, [root]
    while front:
        front = [k for i in front for k in edges[i] if k not in reached and not reached.add(k)]
    return reached


def _solve_component(
    root: int, wanted: dict[tuple[int, int], float], edges: dict[int, list[int]], found: list[float]
) -> None:
    """Factors of all bodies joined to `root` by positive coefficients.

    Walking outwards every factor is a known number times x or 1/x; a cycle of odd length fixes x,
    otherwise x = 1.
    """
    terms = {root: _Term(1.0, 1)}
    front, x = [root], 1.0
    while front:
        i = front.pop()
        for j in edges[i]:
            value = wanted[min(i, j), max(i, j)]
            if j not in terms:
                terms[j] = _Term(value / terms[i].value, -terms[i].power)
                front.append(j)
            elif terms[i].power == terms[j].power:
                x = (value / (terms[i].value * terms[j].value)) ** (0.5 * terms[i].power)
    for i, term in terms.items():
        found[i] = term.value * x**term.power


def _unfit(scene: Scene, effect: PairEffect, i: int, j: int) -> Refusal:
    kind, a, b = type(effect).__name__, scene.names[i], scene.names[j]
    return Refusal(
        f"{kind} {effect.of(a, b):g} between {a!r} and {b!r}: the engine multiplies one coefficient per body, "
        f"and no such coefficients give every pair its own"
    )
