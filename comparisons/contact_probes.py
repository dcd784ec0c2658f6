"""Micro-scenes of bodies that strike and rub; see `comparisons.read_back`.

Balls strike without gravity, because what gravity does during a late impact is the stepping's error and
not the coefficient's.  Friction is read from blocks that cannot turn.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from comparisons.probe import MOTION, Ask, G, Got, Probe, Times, ball, one, reading, several, until
from comparisons.reading import Reading
from mechanics.effects import Force, Friction, Gravity, Resting, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory

PHASES = 8
E, MU = 0.8, 0.5
UNLIKE = 0.5  # asked between unlike materials: what no rule makes of the two
SIZE = 0.2  # edge of a block [m]
FLOOR = Body("floor", HalfSpace())

STRIKES = (1.0, 0.05)  # [m/s]
MEET = 0.1  # time of the first impacts [s]


def _striking(step: float) -> Scene:
    """Balls that fall on a floor without gravity, at two speeds and eight phases of a step each, and pairs of balls."""
    bodies = [FLOOR]
    for n, speed in enumerate(STRIKES):
        for k in range(PHASES):
            gap = speed * (MEET + k / PHASES * step)
            bodies.append(ball(f"{n}-{k}", 1.0 * (n * PHASES + k), 0.1 + gap, velocity=(0.0, 0.0, -speed)))
    for k in range(PHASES):
        x, half = 2.0 * k, 0.1 + 0.5 * (MEET + k / PHASES * step)
        bodies += [
            ball(f"left-{k}", x - half, 5.0, velocity=(0.5, 0.0, 0.0)),
            ball(f"right-{k}", x + half, 5.0, velocity=(-0.5, 0.0, 0.0)),
        ]
    return Scene(tuple(bodies), (Restitution(E),))


def _restitution(_: Scene, motion: Trajectory) -> Iterator[Got]:
    for n, speed in enumerate(STRIKES):
        lanes = slice(1 + n * PHASES, 1 + (n + 1) * PHASES)
        yield several(motion.v[-1, lanes, 2] / speed)
    left, right = (motion.v[-1, 1 + 2 * PHASES + k :: 2, 0] for k in (0, 1))
    yield several(right - left)


MATERIALS = (0.9, 0.4)
RULES = {
    "the product of one factor each": lambda a, b: math.sqrt(a * b),
    "the larger": max,
    "the smaller": min,
    "the mean": lambda a, b: 0.5 * (a + b),
}


def _unlike(between: float, effect: type[Restitution] | type[Friction]) -> tuple[float, dict[tuple[str, str], float]]:
    """Coefficients of bodies named p... and q...: alike among themselves, `between` across."""
    names = ("p1", "p2", "q1", "q2", "p3", "q3")
    alike = {(a, b): MATERIALS["pq".index(a[0])] for i, a in enumerate(names) for b in names[i + 1 :] if a[0] == b[0]}
    return between, alike


def _meeting(between: float) -> Scene:
    """Two balls of one material, two of the other, one of each, head on."""
    bodies = []
    for row, (a, b) in enumerate((("p1", "p2"), ("q1", "q2"), ("p3", "q3"))):
        bodies += [
            ball(a, -0.15, 2.0 * row, velocity=(0.5, 0.0, 0.0)),
            ball(b, 0.15, 2.0 * row, velocity=(-0.5, 0.0, 0.0)),
        ]
    return Scene(tuple(bodies), (Restitution(*_unlike(between, Restitution)),))


def _rule(value: float) -> str:
    """The rule that makes `value` of the two materials, in words."""
    near = [name for name, rule in RULES.items() if abs(rule(*MATERIALS) - value) < 0.02]
    return f"as {near[0]} of the two" if near else ""


def _met(_: Scene, motion: Trajectory) -> Iterator[Got]:
    found = motion.v[-1, 1::2, 0] - motion.v[-1, 0::2, 0]
    yield one(found[2], _rule(found[2]))


def _sliding_pairs(between: float) -> Scene:
    """A block of one material on a slab of it, the same of the other, and one on a slab of the other."""
    bodies = []
    for row, (block, slab) in enumerate((("p1", "p2"), ("q1", "q2"), ("p3", "q3"))):
        x = 20.0 * row
        bodies += [
            Body(slab, Box((10.0, 1.0, 0.5)), None, (x, 0.0, -0.25)),
            Body(block, Box((SIZE, SIZE, SIZE)), 1.0, (x, 0.0, 0.5 * SIZE), velocity=(2.0 * SLIDE, 0.0, 0.0)),
        ]
    return Scene(tuple(bodies), (Gravity((0.0, 0.0, -G)), Friction(*_unlike(between, Friction)), Resting()))


def _slid(_: Scene, motion: Trajectory) -> Iterator[Got]:
    found = _braking(motion)[5]
    yield one(found, _rule(found))


def _geometric(
    reading: Reading,
    scene: Callable[[float], Scene],
    times: Times,
    got: Callable[[Scene, Trajectory], Iterator[Got]],
) -> Callable[[Ask, str], list[Reading]]:
    """What is asked of an engine that has one coefficient per body: the one value a product can make."""

    def instead(ask: Ask, reason: str) -> list[Reading]:
        asked = math.sqrt(MATERIALS[0] * MATERIALS[1])
        world = scene(asked)
        outcome = ask(world, times(0.0)).outcome
        if not isinstance(outcome, Trajectory):
            return [replace(reading, refused=True, said=reason)]
        found = replace(reading, asked=asked, got=next(got(world, outcome))[0])
        rule = f"as {next(iter(RULES))} of the two; " if found.same else ""
        return [replace(found, said=f"{rule}{UNLIKE:g} is refused")]

    return instead


SLIDE = 1.0  # slow, so that what damps a body by its speed hardly shows [m/s]
SHARES = (0.5, 0.9, 0.94, 0.98, 1.02, 1.06, 1.1)  # of the largest force friction can hold


def _window(_: float) -> tuple[float, ...]:
    """Contact settles in the first tenth of a second; the sliding block comes to rest after 0.204 s."""
    return 0.0, 0.1, 0.15


def _block(name: str, x: float, velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Body:
    return Body(name, Box((SIZE, SIZE, SIZE)), 1.0, (x, 0.0, 0.5 * SIZE), velocity=velocity)


def _dragged(_: float) -> Scene:
    """A block that slides and others that are pulled, harder and harder; none may turn."""
    pulled = tuple(_block(f"pulled-{i}", 4.0 * (i + 1)) for i in range(len(SHARES)))
    forces = tuple(Force(b.name, (share * MU * G, 0.0, 0.0)) for b, share in zip(pulled, SHARES, strict=True))
    bodies = (FLOOR, _block("sliding", 0.0, (SLIDE, 0.0, 0.0)), *pulled)
    return Scene(bodies, (Gravity((0.0, 0.0, -G)), Friction(MU), Resting(), *forces))


def _braking(motion: Trajectory) -> np.ndarray:
    """(n,) tangential over normal impulse in the last interval.

    The ratio is Coulomb's coefficient however the normal force varies: a body that hops on a soft
    contact takes as much less friction in the air as more when it lands.
    """
    along = np.linalg.norm(motion.v[:, :, :2], axis=2)
    pressed = G * (motion.t[-1] - motion.t[-2]) + motion.v[-1, :, 2] - motion.v[-2, :, 2]
    return np.asarray((along[-2] - along[-1]) / pressed)


def _friction(_: Scene, motion: Trajectory) -> Iterator[Got]:
    yield one(_braking(motion)[1])
    # a block that slides gains (share - 1) µ g; half of the least of these tells holding from sliding
    slides = -_braking(motion)[2:] > 0.5 * (SHARES[4] - 1.0) * MU
    first = int(np.argmax(slides)) if slides.any() else len(SHARES)
    below = SHARES[first - 1] if first else 0.0
    above = SHARES[first] if first < len(SHARES) else below
    yield one(0.5 * (below + above) * MU, "" if first < len(SHARES) else "holds more than was tried")
    way = motion.x[-1, 2, 0] - motion.x[-2, 2, 0]
    yield one(way / (motion.t[-1] - motion.t[-2]))


def _diagonal(_: float) -> Scene:
    side = SLIDE / math.sqrt(2.0)
    return Scene((FLOOR, _block("sliding", 0.0, (side, side, 0.0))), (Gravity((0.0, 0.0, -G)), Friction(MU), Resting()))


def _diagonally(_: Scene, motion: Trajectory) -> Iterator[Got]:
    yield one(_braking(motion)[1])


_BOUNCE = ("restitution", "impact law", *MOTION)
_SLIP = ("drift", "rest speed", "orientation", "angular", *MOTION)
_RUBS = ("Friction", "Gravity", "Resting")
_MIXED_E = reading("restitution, unlike materials", "1", UNLIKE, 0.02, ("Restitution", "unlike Restitution"), _BOUNCE)
_MIXED_MU = reading("friction, unlike materials", "1", UNLIKE, 0.02, (*_RUBS, "unlike Friction"), _SLIP)

PROBES: tuple[Probe, ...] = (
    Probe(
        (
            reading("restitution at 1 m/s", "1", E, 0.02, ("Restitution",), _BOUNCE),
            reading("restitution at 0.05 m/s", "1", E, 0.02, ("Restitution",), _BOUNCE),
            reading("restitution of two bodies", "1", E, 0.02, ("Restitution",), _BOUNCE),
        ),
        _striking,
        until(0.25),
        _restitution,
    ),
    Probe(
        (_MIXED_E,),
        lambda _: _meeting(UNLIKE),
        until(0.25),
        _met,
        _geometric(_MIXED_E, _meeting, until(0.25), _met),
    ),
    Probe(
        (
            reading("kinetic friction", "1", MU, 0.02 * MU, _RUBS, _SLIP),
            # read between shares 4 % apart
            reading("static friction", "1", MU, 0.03 * MU, _RUBS, _SLIP),
            # of what a gripper may lose in a second without dropping anything
            reading("creep at half the cone", "m/s", 0.0, 1e-4, _RUBS, ("drift", "rest speed", "position", "velocity")),
        ),
        _dragged,
        _window,
        _friction,
    ),
    Probe((reading("kinetic friction, diagonal", "1", MU, 0.02 * MU, _RUBS, _SLIP),), _diagonal, _window, _diagonally),
    Probe(
        (_MIXED_MU,),
        lambda _: _sliding_pairs(UNLIKE),
        _window,
        _slid,
        _geometric(_MIXED_MU, _sliding_pairs, _window, _slid),
    ),
)
