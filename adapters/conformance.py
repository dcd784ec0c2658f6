"""The laws that every adapter has to keep, and the one call that tries them: `check_engine`.

The scenes are small and have closed answers.  A planar engine is tried in the plane; a law about an
effect that an engine does not list is passed as not applicable, and says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from adapters.conformance_scenes import (
    Outcome,
    Refused,
    Undeclared,
    Unlisted,
    Verdict,
    bouncing,
    close,
    crowd,
    distance,
    drive,
    example,
    falling,
    finest,
    gravity,
    listening,
    needs,
    planar,
    step,
    tumbler,
    tumbles,
    turned,
    world,
)
from adapters.engine import Engine, Refusal, defaults, lead, settled
from adapters.run import Failure, prepare, run
from mechanics.effects import EFFECTS, Force, Friction, Gravity, Restitution, Rotation
from mechanics.rotation import about, angle_between
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Shape, Sphere
from mechanics.trajectory import Trajectory

TENSOR = ((1.0, 0.1, 0.2), (0.1, 2.0, 0.3), (0.2, 0.3, 2.5))  # no axis of it is a body axis [kg m2]
ROUNDING = 1e-9  # what thousands of additions in double precision may amount to


@dataclass(frozen=True)
class Law:
    """What came of trying one law.

    Attributes
    ----------
    name : str
    passed : bool
    value : float
        What was measured, in the unit the explanation names; NaN where nothing was.
    explanation : str
        What the value is and how much is allowed; or why the law does not apply; or how the engine broke.
    known : str
        The reason on record if this engine is known to break the law, else "".
    """

    name: str
    passed: bool
    value: float
    explanation: str
    known: str = ""


LAWS: dict[str, Callable[[Engine], Verdict]] = {}


def check_engine(engine: Engine, names: Collection[str] | None = None) -> tuple[Law, ...]:
    """Try the laws on `engine` (a module or an object) and return what came of each, in fixed order.

    Parameters
    ----------
    engine : Engine
    names : collection of str, optional
        Names of the laws to try; all `LAWS` by default.

    Raises
    ------
    ValueError
        For a name that is no law.
    """
    for name in names or ():
        if name not in LAWS:
            raise ValueError(f"there is no law {name!r}; there are: {', '.join(LAWS)}")
    return tuple(_try(engine, name, law) for name, law in LAWS.items() if names is None or name in names)


def _try(engine: Engine, name: str, law: Callable[[Engine], Verdict]) -> Law:
    known = getattr(engine, "known", {}).get(name, "")
    try:
        measured, allowed, what = law(engine)
    except Outcome as outcome:
        return Law(name, outcome.passed, math.nan, outcome.explanation, known)
    except Exception as error:  # an engine may raise anything; that is the finding
        return Law(name, False, math.nan, f"{type(error).__name__}: {error}", known)
    passed = bool(measured <= allowed)  # NaN fails
    return Law(name, passed, float(measured), f"{what}: {measured:.3g}, allowed {allowed:.3g}", known)


def _law(name: str) -> Callable[[Callable[[Engine], Verdict]], Callable[[Engine], Verdict]]:
    def enter(law: Callable[[Engine], Verdict]) -> Callable[[Engine], Verdict]:
        LAWS[name] = law
        return law

    return enter


@_law("reads back the initial state")
def _initial_state(engine: Engine) -> Verdict:
    scene = crowd(engine)
    read = drive(engine, scene, (0.0, 0.1)).at(0)
    return distance(read, scene.start()), 1e-12, "largest difference of any component at t = 0"


@_law("keeps the order of the bodies")
def _order(engine: Engine) -> Verdict:
    scene = crowd(engine, turning=False)
    motion = drive(engine, scene, (0.0, 0.5))
    start = scene.start()
    expected = start.x + np.where([[b.fixed] for b in scene.bodies], 0.0, 0.5 * start.v)
    off = np.abs(motion.x[-1] - expected).max()
    return off, ROUNDING * 100.0, "largest distance from where each body should have drifted [m]"


@_law("keeps every velocity in a vacuum")
def _vacuum(engine: Engine) -> Verdict:
    bodies = tuple(
        Body(f"b{i}", Sphere(0.1), mass, (3.0 * i, 0.0, 1.0), velocity=(speed, 0.0, -0.5 * speed))
        for i, (mass, speed) in enumerate(((1.0, 0.01), (1e3, 7.0), (1e-3, 300.0)))
    )
    motion = drive(engine, Scene(bodies), (0.0, 0.5, 1.0))
    lost = np.linalg.norm(motion.v[-1] - motion.v[0], axis=1) / np.linalg.norm(motion.v[0], axis=1)
    return lost.max(), ROUNDING, "largest relative change of a velocity in 1 s, up to 300 m/s"


@_law("turns nothing without Rotation")
def _no_rotation(engine: Engine) -> Verdict:
    tilted = tuple(about((0.0, 1.0, 0.0), 0.3))
    pushed, carried = (
        Scene(
            (Body("b", Box((0.2, 0.3, 0.4)), 1.0, (0.0, 0.0, 1.0), tilted, (1.0, 0.0, 0.0)),),
            tuple(e for e in (Gravity(), push) if type(e) in engine.effects),
        )
        for push in (
            Force("b", force=(1.0, 0.0, 0.0), torque=(0.0, 1.0, 0.0), point=(0.0, 0.0, 0.1)),
            Force("b", force=(1.0, 0.0, 0.0)),
        )
    )
    # on its edge from the first step on: 0.1 sin 0.3 + 0.2 cos 0.3 = 0.2206 m high
    standing = Body("b", Box((0.2, 0.3, 0.4)), 1.0, (0.0, 0.0, 0.2206), tilted, (0.3, 0.0, -1.0))
    struck = Scene(
        (Body("floor", HalfSpace()), standing),
        tuple(e for e in (Gravity(), Friction(0.5), Restitution(0.5)) if type(e) in engine.effects),
    )
    motions = [drive(engine, carried, (0.0, 0.5))]
    with suppress(Undeclared):  # an engine may also say that a moment calls for Rotation
        motions.append(drive(engine, pushed, (0.0, 0.5)))
    with suppress(Refused):
        motions.append(drive(engine, struck, (0.0, 0.5)))
    most = max(turned(motion) + float(np.abs(motion.w).max()) for motion in motions)
    return most, 1e-12, "turning of a body that is pushed and struck but may not turn, rad + rad/s"


@_law("spins with Rotation")
def _rotation(engine: Engine) -> Verdict:
    needs(engine, Rotation)
    rate = 2.0
    body = Body("b", Sphere(0.1), 1.0, angular_velocity=(0.0, rate, 0.0))
    motion = drive(engine, Scene((body,), (Rotation(),)), (0.0, 0.5), finest(engine))
    off = float(angle_between(motion.q[-1, 0], about((0.0, 1.0, 0.0), 0.5 * rate)))
    drift = float(np.abs(motion.w[-1, 0] - motion.w[0, 0]).max())
    # a first-order update of the quaternion errs by (rate h)^2 rate t / 12, 1e-8 at 1e-4 s
    return off + drift, 1e-6, "error of a steady spin about y after 0.5 s, rad + rad/s"


@_law("falls with g")
def _falls(engine: Engine) -> Verdict:
    g, time = gravity(engine), 0.5
    motion = drive(engine, falling(engine), (0.0, time))
    return np.abs(motion.v[-1] - g * time).max() / 9.81, ROUNDING, "velocity error after 0.5 s over g"


@_law("declares its time levels")
def _time_levels(engine: Engine) -> Verdict:
    g, time = gravity(engine), 0.5
    scene, settings = falling(engine), defaults(engine)
    motion = drive(engine, scene, (0.0, time))
    ahead = lead(engine, settled(engine, settings, scene))
    synchronised = motion.x[-1] - motion.x[0] - ahead * motion.v[-1]
    off = np.abs(synchronised - 0.5 * g * motion.t[-1] ** 2).max()
    # an adaptive engine has no time step to blame and 1e-6 to spend
    return off, ROUNDING if "dt" in engine.knobs else 1e-6, "position error after 0.5 s with the lead taken out [m]"


@_law("lets mass drop out of free fall")
def _mass_drops_out(engine: Engine) -> Verdict:
    motion = drive(engine, falling(engine), (0.0, 0.5))
    fallen = motion.x[-1] - motion.x[0]
    return np.abs(fallen - fallen[0]).max(), ROUNDING, "difference of the fall of 1 g, 1 kg and 1 t in 0.5 s [m]"


@_law("turns in the scene's frames")
def _frames(engine: Engine) -> Verdict:
    needs(engine, Rotation)
    if planar(engine):
        body = Body("b", Box((0.2, 0.3, 0.4)), 1.0, (0.0, 0.0, 0.0), tuple(about((0.0, 1.0, 0.0), 0.7)),
                    angular_velocity=(0.0, 3.0, 0.0))  # fmt: skip
    else:
        body = tumbler((0.5, 1.0, 1.4))
    return tumbles(engine, body)


@_law("honours explicit inertia")
def _inertia(engine: Engine) -> Verdict:
    needs(engine, Rotation)
    if not planar(engine):
        return tumbles(engine, tumbler(TENSOR))
    needs(engine, Force)
    body = Body("b", Sphere(0.1), 1.0, inertia=(0.3, 0.2, 0.3))
    scene = Scene((body,), (Rotation(), Force("b", torque=(0.0, 0.1, 0.0))))
    motion = drive(engine, scene, (0.0, 0.5))
    return abs(motion.w[-1, 0, 1] - 0.25), ROUNDING, "error of the spin that a known torque gives in 0.5 s [rad/s]"


@_law("refuses what it does not list")
def _refuses(engine: Engine) -> Verdict:
    body = Body("b", Sphere(0.1), 1.0)
    accepted = []
    for kind in (Unlisted, *EFFECTS.values()):
        if kind not in engine.effects:
            try:
                prepare(engine, Scene((body, Body("c", Sphere(0.1), 1.0, (1.0, 0.0, 0.0))), (example(kind),)))
                accepted.append(kind.__name__)
            except Refusal:
                continue
    if Unlisted in engine.effects:
        accepted.append("an effect made up for this test")
    return len(accepted), 0, f"effects accepted without being listed ({', '.join(accepted) or 'none'})"


@_law("simulates every shape or refuses it")
def _shapes(engine: Engine) -> Verdict:
    needs(engine, Gravity)
    broken = []
    shapes: tuple[Shape, ...] = (Sphere(0.1), Box((0.1, 0.2, 0.3)), Capsule(0.1, 0.2), Cylinder(0.1, 0.2))
    contact = tuple(e for e in (Restitution(0.5),) if type(e) in engine.effects)
    for shape in shapes:
        scene = Scene((Body("floor", HalfSpace()), Body("b", shape, 1.0, (0.0, 0.0, 0.5))), (Gravity(), *contact))
        outcome = run(engine, scene, (0.0, 0.1)).outcome
        if isinstance(outcome, Failure):
            broken.append(f"{type(shape).__name__}: {outcome.reason}")
    return len(broken), 0, f"shapes that break it ({'; '.join(broken) or 'none'})"


@_law("repeats itself bit for bit")
def _repeats(engine: Engine) -> Verdict:
    if not getattr(engine, "repeats", True):
        raise Outcome(True, "not applicable: it says itself that it does not repeat")
    digests = {drive(engine, bouncing(engine), (0.0, 0.25, 0.5)).digest() for _ in range(3)}
    return len(digests) - 1, 0, "different answers in three runs of one scene, less one"


@_law("a finer step is no worse")
def _finer(engine: Engine) -> Verdict:
    if "dt" not in engine.knobs:
        raise Outcome(True, "not applicable: it has no time step")
    g, time, errors = gravity(engine), 0.5, []
    for dt in (engine.knobs["dt"][0], engine.knobs["dt"][-1]):
        motion = drive(engine, falling(engine), (0.0, time), {"dt": dt})
        errors.append(np.abs(motion.x[-1] - motion.x[0] - 0.5 * g * motion.t[-1] ** 2).max())
    return errors[1] - errors[0], ROUNDING, "growth of the free-fall error from coarsest to finest step [m]"


@_law("accepts its knobs at both ends")
def _knobs(engine: Engine) -> Verdict:
    broken = []
    scene = bouncing(engine)
    for name, ladder in engine.knobs.items():
        for value in dict.fromkeys((ladder[0], ladder[-1])):
            outcome = run(engine, scene, (0.0, 0.1), {name: value}).outcome
            if isinstance(outcome, Failure):
                broken.append(f"{name} = {value}: {outcome.reason}")
    return len(broken), 0, f"settings that break it ({'; '.join(broken) or 'none'})"


@_law("keeps two worlds apart")
def _two_worlds(engine: Engine) -> Verdict:
    scene, other = bouncing(engine), Scene((Body("b", Sphere(0.2), 5.0, velocity=(1.0, 0.0, 0.0)),))
    lonely = world(engine, scene)
    alone = [step(engine, lonely) for _ in range(5)]
    close(engine, lonely)
    first, second = world(engine, scene), world(engine, other)
    beside = []
    for _ in range(4):
        beside.append(step(engine, first))
        step(engine, second)
    close(engine, second)
    beside.append(step(engine, first))  # and goes on when the other is gone
    close(engine, first)
    off = sum(Trajectory.of([a]).digest() != Trajectory.of([b]).digest() for a, b in zip(alone, beside, strict=True))
    return off, 0, "states of five that differ, in any bit, between a world alone and one beside another"


@_law("says nothing on stdout")
def _silent(engine: Engine) -> Verdict:
    with listening() as heard:
        run(engine, bouncing(engine), (0.0, 0.1))
    text = heard[0].strip()
    return len(text), 0, f"characters printed ({text[:60]!r})"
