"""The algorithm, on one page.

    until the time asked for is reached
        where something has just met or lies on something:
            exchange impulses until nothing approaches          (effects.impact)
            find the contacts that last, and their forces        (effects.resting)
        let all bodies move to the next contact, at the latest to the time asked for:
            bodies in flight on their exact paths                (integrators)
            bodies in lasting contact by Runge-Kutta steps        (lasting)
            looking for the first contact on the way             (time_of_contact)

Nothing is rounded to a time step: bodies are carried exactly to each contact, and effects that the
scene does not declare have no part in it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mechanics.scene import Scene
from mechanics.trajectory import Trajectory
from reference_impl import lasting
from reference_impl.assemble import IMPULSES, Table, assemble
from reference_impl.bounces.flock import Flock, suits
from reference_impl.collide.detect import COARSE, Detector, Search, kinematics, rotations
from reference_impl.effects import tether
from reference_impl.errors import Overlap, Stalled
from reference_impl.links import Links
from reference_impl.moments import require_rotation
from reference_impl.settings import Settings
from reference_impl.settle import settle
from reference_impl.state import Bodies, bodies_of, motion_of
from reference_impl.world import HELD, Scales, World

TOUCH = 1e-9  # features closer than this touch [smallest body size]
QUIET = 1e-12  # slower approach is none [speed scale]
PART = 1e-9  # slower separation is none [speed scale]
CROWD = 100_000  # turns of the algorithm allowed within a thousandth of the scene's time scale


def simulate(scene: Scene, times: Sequence[float], settings: Settings | None = None) -> Trajectory:
    """Motion of `scene` at `times` [s], which increase from 0 on.

    Raises
    ------
    Unsupported
        For an effect or a contact of shapes the engine has no part for.
    MissingEffect
        If the motion needs an effect that is not declared.
    Overlap
        If bodies overlap at the start.
    Stalled
        If a budget ran out.
    """
    world = begin(scene, settings)
    states = []
    for t in times:
        if t > world.t:
            advance(world, t - world.t)
        states.append(world.state())
    return Trajectory.of(states)


def begin(scene: Scene, settings: Settings | None = None, table: Table = IMPULSES) -> World:
    """World of a scene at t = 0.

    Raises
    ------
    Unsupported, MissingEffect, Overlap
        As in `simulate`.
    """
    settings = settings or Settings()
    parts = assemble(scene, table)
    unloaded = bodies_of(scene)
    bodies = parts.loaded(unloaded, 0.0)
    scales = _scales(scene, bodies)
    search = Search(
        settings.time_of_contact, settings.tolerance * scales.length,
        max(TOUCH, 10.0 * settings.tolerance) * scales.length, QUIET * scales.speed,
        PART * scales.speed, COARSE * scales.length,
    )  # fmt: skip
    detector = Detector(scene, bodies, search, tether.all_of(parts.cords))
    links = Links.of(parts, bodies.inverse_mass > 0.0)
    world = World(scene, settings, parts, bodies, unloaded, motion_of(scene, bodies), scales, detector, search, links)
    _refuse_overlap(world)
    require_rotation(world)
    for i in range(len(scene.bodies)):
        world.launch(i)
    if suits(world):
        world.flock = Flock(world)
    return world


def advance(world: World, duration: float) -> None:
    """Carry the world `duration` [s] on.

    Raises
    ------
    MissingEffect, Stalled
        As in `simulate`; the world then stands where it got to.
    """
    target = world.t + duration
    budget = world.audit.events + world.settings.events
    tries = world.audit.steps + world.audit.rejected + world.settings.steps
    since, turns, spent = world.t, 0, ""
    while world.t < target and not spent:
        if world.dirty.any():
            world.arrive()
            world.recall()
            settle(world)
            lasting.embark(world, _next_switch(world))
        if not world.dirty.any():  # else impulses have taken the place of forces, at this very time
            _move(world, target, budget + 1 - world.audit.events)
        turns += 1
        if world.t > since + 1e-3 * world.scales.time:
            since, turns = world.t, 0
        if world.audit.events > budget:
            spent = f"more than {world.settings.events} contacts in one call"
        elif world.audit.steps + world.audit.rejected > tries:
            spent = f"more than {world.settings.steps} steps of lasting contact in one call"
        elif turns > CROWD:
            spent = f"more than {CROWD} contacts without progress in time"
    lasting.show(world)
    if spent:
        raise Stalled(spent, world.t)


def _move(world: World, target: float, events: int) -> None:
    """All bodies on their ways: to the first contact, the first end of a step, or to `target` [s].

    Where all fly, isolated bounces of spheres on the way are dealt with there, at most `events` of them.
    """
    limit = min(target, _next_switch(world), world.horizon())
    met: Sequence[int] = ()
    if world.flock is not None and not (world.mode == HELD).any():
        time, met = world.flock.run(world, limit, events)
        world.wait(time)
    elif world.untouchable:
        time = limit
        world.wait(time)
    else:
        time, pair = world.first_hit(limit)
        if pair >= 0 and not lasting.cut(world, pair, time):
            return
        world.carry(time)
        lasting.arrive(world)
        if pair >= 0:
            met = world.detector.pairs[pair].tolist()
            world.clear[pair], world.hits[pair] = time, False
        world.renew()
    if len(met):
        world.dirty[list(met)] = True
    elif time == _next_switch(world, before=time):
        world.arrive()
        _switch(world)


def _next_switch(world: World, before: float | None = None) -> float:
    """Next time at which a load begins or ends [s]; inf if none will."""
    now = world.t if before is None else before
    later = [t for t in world.parts.switches() if (t > now if before is None else t == now)]
    return later[0] if later else np.inf


def _switch(world: World) -> None:
    """The loads change now: every body starts a new flight, and every contact is looked at again."""
    everything = np.ones(len(world.dirty), dtype=bool)
    world.bodies = world.detector.bodies = world.parts.loaded(world.unloaded, world.t)
    require_rotation(world)
    world.energy[:] = np.nan  # of other loads
    world.mode[:] = 0
    for i in range(len(world.dirty)):
        world.launch(i)
    world.dirty[:] = True
    world.forget(everything)


def _scales(scene: Scene, b: Bodies) -> Scales:
    free = b.inverse_mass > 0.0
    start = scene.start()
    length = float(b.reach[free].min()) if free.any() else 1.0
    # tolerances must stay above the rounding of the coordinates, whatever the size of the bodies
    length = max(length, 1e-3 * float(np.abs(start.x).max()))
    fastest = float(
        max(np.linalg.norm(start.v, axis=1).max(), (np.linalg.norm(start.w, axis=1) * _finite(b.reach)).max())
    )
    pull = float(np.linalg.norm(b.acceleration, axis=1).max())
    speed = max(fastest, (pull * length) ** 0.5)
    return Scales(length, speed or 1.0, length / (speed or 1.0))


def _finite(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, 0.0)


def _refuse_overlap(world: World) -> None:
    m, everything = world.motion, np.ones(len(world.dirty), dtype=bool)
    rotation = rotations(m.q)
    for p, (a, b) in enumerate(world.detector.pairs.tolist()):
        depth = world.detector.overlap(p, m.x, rotation)
        if depth > world.search.touch:
            raise Overlap((world.scene.names[a], world.scene.names[b]), depth, 0.0)
    contacts = world.detector.contacts(m.x, rotation, everything)
    contacts = contacts.chosen(contacts.pairs < world.detector.solid)
    if len(contacts.kinds) == 0:
        return
    gap = kinematics(contacts, m.x, rotation, m.v, np.zeros_like(m.v)).gap
    worst = int(np.argmin(gap))
    if gap[worst] < -world.search.touch:
        a, b = contacts.kinds[worst, :2].tolist()
        raise Overlap((world.scene.names[a], world.scene.names[b]), -float(gap[worst]), 0.0)
