"""The same scenario seen from a little later: where in a time step its impacts fall.

An engine with time steps meets an impact at some phase of a step, and what it makes of it depends on
that phase.  Starting a scenario later by a fraction of a step, on the same path, moves every impact to
another phase and changes nothing else: the bodies, the impacts and the truth are the same.  A change of
the height of release would change the speed of the impact, too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.effects import Drag, Force, Hinge, Resting, Restitution, Rod, Spring, Tether
from mechanics.scene import Scene
from mechanics.trajectory import State
from scenarios.scenario import Scenario, Truth

STEP = 1e-3  # over which phases are spread for an engine without a time step [s]


def has_phase(scenario: Scenario) -> bool:
    """Whether the scenario is about impacts, and can be begun later: its path up to the first is known."""
    scene = scenario.scene
    timed = any(f.start > 0.0 or f.end < np.inf for f in scene.all(Force))
    known = scenario.truth is not None or (
        scene.needs.isdisjoint({Drag, Force, Spring, Rod, Tether, Hinge, Resting})
        and not any(any(b.angular_velocity) for b in scene.bodies)
    )
    return Restitution in scene.needs and known and not timed


def delays(scenario: Scenario, phases: int, step: float = STEP) -> tuple[float, ...]:
    """Delays [s] that spread the impacts of a scenario evenly over the phases of a step; 0 alone if it has no phase."""
    spread = tuple(k / phases * step for k in range(phases))
    free = has_phase(scenario) and all(t > spread[-1] for t in scenario.events)
    return spread if free else (0.0,)


def later(scenario: Scenario, delay: float) -> Scenario:
    """The scenario begun `delay` [s] later on its own path, for as long as before.

    Raises
    ------
    ValueError
        For a scenario without phase (see `has_phase`), or one with an impact within the delay.
    """
    if delay == 0.0:
        return scenario
    if not has_phase(scenario):
        raise ValueError(f"{scenario.name}: its path is not known, or it has no impacts")
    if any(t <= delay for t in scenario.events):
        raise ValueError(f"{scenario.name}: an impact at {min(scenario.events):g} s, within the delay of {delay:g} s")
    state, truth = _after(scenario, delay), scenario.truth
    return replace(
        scenario,
        scene=_begun(scenario.scene, state),
        truth=None if truth is None else _shifted(truth, delay),
        events=tuple(t - delay for t in scenario.events),
    )


def _after(scenario: Scenario, delay: float) -> State:
    if scenario.truth is not None:
        return scenario.truth(np.array([delay])).at(0)
    scene, start = scenario.scene, scenario.scene.start()
    pull = np.array([b.acceleration if b.fixed else scene.gravity for b in scene.bodies])
    x = start.x + delay * start.v + 0.5 * delay**2 * pull
    return State(delay, x, start.q, start.v + delay * pull, start.w)


def _begun(scene: Scene, state: State) -> Scene:
    """The scene with its bodies in another state; what did not move keeps its numbers bit by bit."""
    places = (state.x, state.q, state.v, state.w)
    names = ("position", "orientation", "velocity", "angular_velocity")
    bodies = []
    for i, body in enumerate(scene.bodies):
        moved = {n: tuple(a[i].tolist()) for n, a in zip(names, places, strict=True)}
        bodies.append(replace(body, **moved))
    return Scene(tuple(bodies), scene.effects)


def _shifted(truth: Truth, delay: float) -> Truth:
    return lambda t: replace(truth(t + delay), t=t)
