"""How an engine is tried: small scenes that any engine can be asked for, and the run that ends a law early."""

from __future__ import annotations

import ctypes
import math
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from adapters.engine import Engine, Refusal, Settings, checked_settings
from adapters.run import prepare, run
from mechanics.effects import Drag, Effect, Gravity, Restitution, Rotation
from mechanics.rotation import about, angle_between, matrix, product, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import State, Trajectory

Verdict = tuple[float, float, str]  # measured, allowed, what it is


class Outcome(Exception):
    """Ends a law early: it does not apply, or the engine broke."""

    def __init__(self, passed: bool, explanation: str) -> None:
        self.passed, self.explanation = passed, explanation


class Refused(Outcome):
    """The engine refused the scene."""


class Undeclared(Outcome):
    """The engine said that the scene needs an effect that it does not declare."""


@dataclass(frozen=True)
class Unlisted(Effect):
    """An effect that no engine can know."""


def example(kind: type[Effect]) -> Effect:
    """Some effect of that type between the bodies b and c."""
    arguments: dict[str, Any] = {
        "Force": {"body": "b"},
        "Spring": {"a": "b", "b": "c", "stiffness": 1.0, "length": 1.0},
        "Rod": {"a": "b", "b": "c"},
        "Tether": {"a": "b", "b": "c", "length": 2.0},
        "Hinge": {"a": "b", "b": "c"},
        "Restitution": {"coefficient": 0.5},
        "Friction": {"coefficient": 0.5},
    }
    return kind(**arguments.get(kind.__name__, {}))


def drive(
    engine: Engine, scene: Scene, times: Sequence[float], settings: Settings | None = None, optional: bool = False
) -> Trajectory:
    """The motion; a failure ends the law, and so does a refusal, which is no offence where the scene is `optional`."""
    outcome = run(engine, scene, times, settings).outcome
    if isinstance(outcome, Trajectory):
        return outcome
    if isinstance(outcome, Refusal):
        word = "not applicable: it refuses" if optional else "it refuses"
        raise Refused(optional, f"{word} the scene ({outcome.reason})")
    kind = Undeclared if "does not declare" in outcome.reason else Outcome
    raise kind(False, f"{outcome.state} in {outcome.stage}: {outcome.reason}")


def needs(engine: Engine, kind: type[Effect]) -> None:
    if kind not in engine.effects:
        raise Outcome(True, f"not applicable: it lists no {kind.__name__}")


def planar(engine: Engine) -> bool:
    """Whether the engine refuses motion across the x-z plane."""
    scene = Scene((Body("b", Sphere(0.1), 1.0, velocity=(0.0, 1.0, 0.0)),))
    return isinstance(run(engine, scene, (0.0, 0.01)).outcome, Refusal)


def finest(engine: Engine) -> Settings:
    return {"dt": engine.knobs["dt"][-1]} if "dt" in engine.knobs else {}


def crowd(engine: Engine, turning: bool = True) -> Scene:
    """Bodies of all kinds, far apart, moving and standing in no order."""
    across = 0.0 if planar(engine) else 1.0
    spin = turning and Rotation in engine.effects
    tilted = about((0.0, 1.0, 0.0), 0.4) if not across else about((1.0, 2.0, 3.0), 0.4)
    turn = (0.3 * across, 0.5, -0.2 * across) if spin else (0.0, 0.0, 0.0)
    bodies = (
        Body("last", Sphere(0.1), 2.0, (1.0, 0.0, 5.0), velocity=(0.1, 0.2 * across, 0.3)),
        Body("post", Box((0.2, 0.2, 0.2)), None, (-4.0, 0.0, 1.0)),
        Body("first", Box((0.1, 0.2, 0.3)), 0.5, (9.0, 0.0, 2.0), tuple(tilted), (-0.4, 0.1 * across, 0.2), turn),
        Body("middle", Sphere(0.3), 40.0, (5.0, 0.0, -3.0), velocity=(0.0, -0.3 * across, -0.1)),
    )
    return Scene(bodies, (Rotation(),) if spin else ())


def gravity(engine: Engine) -> np.ndarray:
    needs(engine, Gravity)
    return np.array([0.5, 0.0 if planar(engine) else 0.25, -9.81])


def falling(engine: Engine) -> Scene:
    """Masses of 1 kg, 1 g and 1 t fall from rest."""
    g = gravity(engine)
    bodies = tuple(Body(f"b{i}", Sphere(0.1), mass, (3.0 * i, 0.0, 0.0)) for i, mass in enumerate((1.0, 1e-3, 1e3)))
    return Scene(bodies, (Gravity(tuple(g.tolist())),))


def bouncing(engine: Engine) -> Scene:
    """A ball that falls, and bounces and feels drag where the engine can."""
    wanted = (Gravity(), Restitution(0.7), Drag(0.1), Rotation())
    bodies = (Body("floor", HalfSpace()), Body("b", Sphere(0.1), 1.0, (0.0, 0.0, 0.3), velocity=(0.5, 0.0, 0.0)))
    return Scene(bodies, tuple(e for e in wanted if type(e) in engine.effects))


def tumbler(inertia: Any) -> Body:
    """A turned body with three different moments that spins about no axis of its own."""
    q = about((1.0, -2.0, 0.5), 1.1)
    spin = (1.0, 3.0, -2.0)
    return Body("b", Sphere(0.1), 1.0, orientation=tuple(q), angular_velocity=spin, inertia=inertia)


def tumbles(engine: Engine, body: Body) -> Verdict:
    """Attitude error of a free body after half a second against the house's own integration of Euler's equations."""
    motion = drive(engine, Scene((body,), (Rotation(),)), (0.0, 0.5), finest(engine), optional=True)
    off = float(angle_between(motion.q[-1, 0], euler(body, float(motion.t[-1]))))
    # a first-order engine errs by some 0.3 rad/s2 x h, 3e-5 rad at the finest step; a mistaken frame by 0.1 rad
    return off, 1e-3, "attitude error of a free body after 0.5 s [rad]"


def euler(body: Body, time: float, steps: int = 400) -> np.ndarray:
    """Attitude of a torque-free body at `time`: fourth-order Runge-Kutta on q' = ω q / 2 with L constant."""
    q, tensor, h = np.array(body.orientation), body.inertia_tensor, time / steps
    turn = matrix(q)
    momentum = turn @ tensor @ turn.T @ np.array(body.angular_velocity)
    inverse = np.linalg.inv(tensor)

    def rate(q: np.ndarray) -> np.ndarray:
        q = q / np.linalg.norm(q)
        spin = rotate(q, inverse @ (matrix(q).T @ momentum))
        return 0.5 * product(np.concatenate([[0.0], spin]), q)

    for _ in range(steps):
        a = rate(q)
        b = rate(q + 0.5 * h * a)
        c = rate(q + 0.5 * h * b)
        q = q + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(q + h * c))
        q = q / np.linalg.norm(q)
    return q


def turned(motion: Trajectory) -> float:
    return float(angle_between(motion.q[-1], motion.q[0]).max())


def distance(a: State, b: State) -> float:
    """Largest difference of two states: of any component, and of attitudes by angle; infinite if they do not match."""
    if a.x.shape != b.x.shape:
        return math.inf
    parts = [np.abs(getattr(a, name) - getattr(b, name)).max() for name in ("x", "v", "w")]
    return float(max(*parts, angle_between(a.q, b.q).max(), abs(a.t - b.t)))


def world(engine: Engine, scene: Scene) -> Any:
    draft, _ = prepare(engine, scene)
    return engine.start(draft, checked_settings(engine, None))


def step(engine: Engine, world: Any) -> State:
    engine.advance(world, 0.1)
    return engine.read(world)


def close(engine: Engine, world: Any) -> None:
    if hasattr(engine, "close"):
        engine.close(world)


@contextmanager
def listening() -> Iterator[list[str]]:
    """Collect what is written to stdout, also by C code; the list holds it afterwards."""
    heard: list[str] = []
    library = ctypes.CDLL(None) if os.name == "posix" else SimpleNamespace(fflush=lambda _: None)
    library.fflush(None)
    with tempfile.TemporaryFile() as file:
        kept = os.dup(1)
        os.dup2(file.fileno(), 1)
        try:
            yield heard
        finally:
            library.fflush(None)
            os.dup2(kept, 1)
            os.close(kept)
            with suppress(OSError):
                file.seek(0)
                heard.append(file.read().decode(errors="replace"))
