"""Micro-scenes of bodies that fly and turn; see `comparisons.read_back`.

Every probe is arranged so that one effect is read without the others: a body thrown up is read where it
comes down as fast as it went up, so that drag, being odd in the velocity, cancels from gravity; a body
under torque likewise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from comparisons.probe import MOTION, TURN, G, Got, Probe, at_once, ball, one, reading, until
from comparisons.reading import GIVEN, Reading
from mechanics.effects import Force, Gravity, Rotation
from mechanics.rotation import exponential, matrix
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Sphere
from mechanics.trajectory import Trajectory


def _thrown(_: float) -> Scene:
    return Scene((ball("ball", 0.0, 0.0, velocity=(0.0, 0.0, 0.1 * G)),), (Gravity((0.0, 0.0, -G)),))


def _gravity(_: Scene, motion: Trajectory) -> Iterator[Got]:
    yield one(-(motion.v[-1, 0, 2] - motion.v[0, 0, 2]) / (motion.t[-1] - motion.t[0]))


COASTING = (0.01, 10.0)  # [m/s]
CAST = (30.0, 300.0, 3e3, 3e4)  # [m/s]


def _coasting(_: float) -> Scene:
    speeds = (*COASTING, *CAST)
    return Scene(tuple(ball(f"b{i}", 0.0, 3.0 * i, velocity=(v, 0.0, 0.0)) for i, v in enumerate(speeds)))


def _rates(motion: Trajectory, speeds: np.ndarray) -> Iterator[Got]:
    """Decay rates of the two slow bodies, then the speed at which the fast ones are cut off."""
    span = float(motion.t[-1] - motion.t[0])
    for before, after in zip(speeds[0, :2], speeds[-1, :2], strict=True):
        yield one(math.log(before / after) / span if after > 0.0 else math.inf)
    kept = np.abs(speeds[1, 2:])  # after one step: what damps explicitly may even turn the fastest round
    capped = abs(kept[-1] - kept[-2]) <= 1e-6 * kept[-1]
    yield one(kept[-1] if capped else math.inf)


def _linear(_: Scene, motion: Trajectory) -> Iterator[Got]:
    return _rates(motion, motion.v[:, :, 0])


SPINNING = (0.01, 10.0)  # [rad/s]


def _spinning(_: float) -> Scene:
    spins = (*SPINNING, *CAST)
    bodies = tuple(ball(f"b{i}", 0.0, 3.0 * i, angular_velocity=(0.0, w, 0.0)) for i, w in enumerate(spins))
    return Scene(bodies, (Rotation(),))


def _angular(_: Scene, motion: Trajectory) -> Iterator[Got]:
    return _rates(motion, motion.w[:, :, 1])


def _drifting(_: float) -> Scene:
    return Scene((ball("ball", 0.0, 0.0, velocity=(1e-3, 0.0, 0.0)),))


def _awake(_: Scene, motion: Trajectory) -> Iterator[Got]:
    """Whether the body is at rest: a speed below a hundredth, which damping does not reach in this time."""
    stopped = abs(motion.v[-1, 0, 0]) < 1e-2 * motion.v[0, 0, 0]
    yield one(float(stopped), "at 1 mm/s for 3 s")


TWIST = 10.0  # angular acceleration asked for [rad/s2]
PUSHED = 0.1  # [s]
MOMENTS = (0.02, 0.03, 0.04)  # [kg m2]
FORMS = (
    ("Sphere", Sphere(0.1), None),
    ("Box", Box((0.1, 0.2, 0.3)), None),
    ("Capsule", Capsule(0.05, 0.2), None),
    (GIVEN, Box((0.1, 0.2, 0.3)), MOMENTS),
)


def _twisted(_: float) -> Scene:
    start = (0.0, -0.5 * TWIST * PUSHED, 0.0)
    bodies = tuple(
        Body(name, shape, 1.0, (2.0 * i, 0.0, 0.0), angular_velocity=start, inertia=inertia)
        for i, (name, shape, inertia) in enumerate(FORMS)
    )
    torques = tuple(Force(b.name, torque=(0.0, TWIST * b.inertia_tensor[1, 1], 0.0)) for b in bodies)
    return Scene(bodies, (Rotation(), *torques))


def _inertia(scene: Scene, motion: Trajectory) -> Iterator[Got]:
    span = motion.t[-1] - motion.t[0]
    for body, gained in zip(scene.bodies, motion.w[-1, :, 1] - motion.w[0, :, 1], strict=True):
        yield one(TWIST * span / gained * body.inertia_tensor[1, 1] if gained else math.inf)


def _tumbling(_: float) -> Scene:
    body = Body("box", Box((0.3, 0.2, 0.1)), 1.0, angular_velocity=(2.0, 2.0, 2.0), inertia=MOMENTS)
    return Scene((body,), (Rotation(),))


def _gyroscopic(scene: Scene, motion: Trajectory) -> Iterator[Got]:
    """1 if the angular momentum stays, 0 if the angular velocity stays instead: their share along the difference."""
    tensor, w = scene.bodies[0].inertia_tensor, motion.w[0, 0]

    def momentum(turn: np.ndarray, spin: np.ndarray) -> np.ndarray:
        return np.asarray(turn @ tensor @ turn.T @ spin)

    start = momentum(matrix(motion.q[0, 0]), w)
    without = momentum(matrix(exponential(w * (motion.t[-1] - motion.t[0]))), w) - start
    gone = momentum(matrix(motion.q[-1, 0]), motion.w[-1, 0]) - start
    yield one(1.0 - float(gone @ without) / float(without @ without))


_TURNS = ("Rotation",)


def _moment(body: Body, about: str) -> Reading:
    """Inertia about y; 1 %, because shapes have theirs in closed form and meshes nearly so."""
    asked = float(body.inertia_tensor[1, 1])
    name = about if about == GIVEN else f"inertia of a {about.lower()}"
    return reading(name, "kg.m2", asked, 1e-2 * asked, (*_TURNS, about), TURN)


PROBES: tuple[Probe, ...] = (
    # 0.1 %: drag of first order cancels, that of second order leaves up to 0.02 %
    Probe((reading("gravity", "m/s2", G, 1e-3 * G, ("Gravity",), MOTION),), _thrown, until(0.2), _gravity),
    Probe(
        (
            # a rate of 1e-4 takes a thousandth of a speed in 10 s
            reading("linear damping at 0.01 m/s", "1/s", 0.0, 1e-4, (), (*MOTION, "momentum")),
            reading("linear damping at 10 m/s", "1/s", 0.0, 1e-4, (), (*MOTION, "momentum")),
            reading("speed cap", "m/s", math.inf, 0.0, (), (*MOTION, "momentum")),
        ),
        _coasting,
        at_once,
        _linear,
    ),
    Probe((reading("asleep", "1", 0.0, 0.0, (), (*MOTION, "momentum")),), _drifting, until(3.0), _awake),
    Probe(
        (
            reading("angular damping at 0.01 rad/s", "1/s", 0.0, 1e-4, _TURNS, (*TURN, "momentum")),
            reading("angular damping at 10 rad/s", "1/s", 0.0, 1e-4, _TURNS, (*TURN, "momentum")),
            reading("spin cap", "rad/s", math.inf, 0.0, _TURNS, (*TURN, "momentum")),
        ),
        _spinning,
        at_once,
        _angular,
    ),
    Probe(
        tuple(
            _moment(body, shape if inertia is None else GIVEN)
            for body, (shape, _, inertia) in zip(_twisted(0.0).bodies, FORMS, strict=True)
        ),
        _twisted,
        until(PUSHED),
        _inertia,
    ),
    # first-order steps lose or gain a few thousandths of it in a tenth of a second
    Probe((reading("gyroscopic term", "1", 1.0, 0.05, _TURNS, TURN),), _tumbling, until(0.1), _gyroscopic),
)
