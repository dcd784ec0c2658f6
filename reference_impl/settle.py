"""What happens at an instant: impulses at contacts that approach, then who stays in contact with whom.

The classification by the normal relative velocity u of a touching contact is made here and nowhere else:

    colliding    u < -floor
    resting      up to a speed too small to part (or back within a moment)
    separating   above
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide.detect import Contacts, Kinematics, kinematics
from reference_impl.contact_problem import NoSolution
from reference_impl.effects.impact import LAWS, Collision
from reference_impl.effects.resting import Island, Pose, carried, islands, push, scaled_loads, shift_bodies
from reference_impl.errors import MissingEffect, Stalled
from reference_impl.world import FLYING, HELD, STILL, Collided, Held, World

RETURN = 5e-6  # a contact that is back within this time never parted [time scale]
RETURN_ALONE = 1e-8  # the same for a sphere with one contact
ACCUMULATION = 1e-3  # bounces of a body that would all happen within this time are skipped [time scale]
ACCUMULATION_ALONE = 1e-7  # the same for a sphere with one contact, whose bounces are cheap
REST_SPEED = 1e-10  # [speed scale]
REST_ACCELERATION = 1e-9  # [speed scale / time scale]


def settle(world: World) -> None:
    """Deal with every contact of the bodies that are dirty, and start their new motion."""
    cluster = world.dirty.copy()
    pose = _pose(world)
    contacts = world.detector.contacts(world.motion.x, pose.rotation, cluster)
    lasting = contacts.chosen(np.zeros(0, dtype=np.int64))
    world.mode[cluster] = FLYING
    if len(contacts.kinds):
        k = kinematics(contacts, pose.x, pose.rotation, pose.v, pose.w)
        world.audit.gap = min(world.audit.gap, float(k.gap.min()))
        world.audit.events += 1
        k = _collide(world, contacts, k, pose)
        lasting = contacts.chosen(_resting(world, contacts, k))
    _hold(world, lasting, cluster)
    for i in np.flatnonzero(cluster & (world.mode != HELD)):
        world.launch(i)
    world.forget(cluster)
    world.dirty[:] = False


def _pose(world: World) -> Pose:
    m = world.motion
    return Pose.of(m.x, m.q, m.v, m.L, world.bodies)


def _together(contacts: Contacts, world: World) -> Island:
    """All contacts as one group."""
    free = sorted({i for i in contacts.kinds[:, :2].ravel().tolist() if world.bodies.inverse_mass[i] > 0.0})
    place = np.full(len(world.mode), -1)
    place[free] = np.arange(len(free))
    return Island(free, contacts, np.arange(len(contacts.kinds)), place)


def _scaled_velocity(world: World, bodies: list[int], pose: Pose) -> np.ndarray:
    b, m = world.bodies, world.motion
    out = np.empty((len(bodies), 6))
    for at, i in enumerate(bodies):
        out[at, :3] = m.v[i] / math.sqrt(b.inverse_mass[i])
        out[at, 3:] = b.root[i].T @ (pose.rotation[i].T @ m.L[i])
    return out.ravel()


def approach_acceleration(world: World, island: Island, g: np.ndarray, k: Kinematics, pose: Pose) -> np.ndarray:
    """Acceleration with which each contact would close if no contact force acted, -gap'' [m/s2]."""
    b = world.bodies
    fixed = np.where(b.inverse_mass[:, None] == 0.0, b.acceleration, 0.0)
    free = g @ scaled_loads(island.bodies, pose, b)
    return -(k.bias + free + carried(island.contacts.kinds[:, :2], k.normal, fixed))


def _collide(world: World, contacts: Contacts, k: Kinematics, pose: Pose) -> Kinematics:
    """Exchange impulses at the contacts that approach; kinematics afterwards.

    Raises
    ------
    MissingEffect
        If bodies collide in a scene without Restitution.
    """
    floor = world.search.speed
    if not (k.rate < -floor).any():
        return k
    law, names = world.parts.law, world.scene.names
    worst = int(np.argmin(k.rate))
    if law.restitution is None and k.rate[worst] < -world.search.parting:
        a, b = contacts.kinds[worst, :2].tolist()
        why = f"bodies collide at {-k.rate[worst]:.6g} m/s"
        raise MissingEffect("Restitution", (names[a], names[b]), world.t, why)
    island = _together(contacts, world)
    g = island.rows(k, pose.x, pose.rotation, world.bodies)
    motion = _scaled_velocity(world, island.bodies, pose)
    closing = approach_acceleration(world, island, g, k, pose)
    e = np.zeros(len(contacts.kinds))
    if law.restitution is not None:
        e[:] = [law.restitution.of(names[a], names[b]) for a, b in contacts.kinds[:, :2].tolist()]
    alone = _alone(g)
    limit = (ACCUMULATION_ALONE if alone else ACCUMULATION) * world.scales.time

    def restitution(u: np.ndarray) -> np.ndarray:
        # all further bounces of a contact take 2 e |u| / (a (1 - e)); they are skipped once that is short
        left = np.full(len(u), math.inf)
        ends = (u < 0.0) & (closing > 0.0) & (e < 1.0)
        left[ends] = 2.0 * e[ends] * -u[ends] / (closing[ends] * (1.0 - e[ends]))
        if alone and left[0] < limit and e[0] > 0.0:
            world.audit.last_bounce = world.t + float(left[0])
        return np.where(left < limit, 0.0, e)

    drift = k.rate - g @ motion if world.moving else np.zeros(len(e))
    try:
        outcome = LAWS[world.settings.impact_law](Collision(g, motion, drift, restitution, floor))
    except NoSolution as error:
        raise Stalled(f"impact: {error}", world.t) from None
    _exchange(world, contacts, k, pose, outcome.impulses, outcome.passes)
    after = _pose(world)
    return kinematics(contacts, after.x, after.rotation, after.v, after.w)


def _exchange(world: World, contacts: Contacts, k: Kinematics, pose: Pose, impulses: np.ndarray, passes: int) -> None:
    """Add the impulses to the motion, and put them on record."""
    b, m = world.bodies, world.motion
    before = kinetic_energy(world, pose)
    for row, p in enumerate(impulses.tolist()):
        if p == 0.0:
            continue
        ends = contacts.kinds[row, :2].tolist()
        n, point = k.normal[row], k.point[row]
        for sign, i in zip((p, -p), ends, strict=True):
            m.v[i] += sign * b.inverse_mass[i] * n
            if b.quickness[i] > 0.0:
                m.L[i] += sign * np.cross(point - m.x[i], n)
        world.events.append(Collided(world.t, ends[0], ends[1], tuple(point.tolist()), tuple(n.tolist()), p))
        world.audit.impacts += 1
    world.audit.passes = max(world.audit.passes, passes)
    if not world.moving:
        rise = kinetic_energy(world, _pose(world)) - before
        world.audit.energy_rise = max(world.audit.energy_rise, rise)


def kinetic_energy(world: World, pose: Pose) -> float:
    """Kinetic energy of all moving bodies [J]."""
    b, m = world.bodies, world.motion
    free = b.inverse_mass > 0.0
    square = np.einsum("ij,ij->i", m.v[free], m.v[free])
    turning = np.einsum("ij,ij->", pose.w[free], m.L[free])
    return 0.5 * float((square / b.inverse_mass[free]).sum() + turning)


def _resting(world: World, contacts: Contacts, k: Kinematics) -> np.ndarray:
    """Which contacts stay: not parting, or back at once."""
    stays = k.rate <= world.search.parting
    if stays.all():
        return stays
    pose = _pose(world)
    island = _together(contacts, world)
    g = island.rows(k, pose.x, pose.rotation, world.bodies)
    closing = approach_acceleration(world, island, g, k, pose)
    moment = RETURN_ALONE if _alone(g) else RETURN
    return stays | (k.rate <= 0.5 * closing * moment * world.scales.time)


def _alone(g: np.ndarray) -> bool:
    """Whether one contact of a body that it cannot turn is all there is: a sphere on its own."""
    return len(g) == 1 and not g[:, 3:6].any()


def _hold(world: World, lasting: Contacts, cluster: np.ndarray) -> None:
    """Put bodies with lasting contacts under contact forces, or to rest.

    Raises
    ------
    MissingEffect
        If contact forces are needed and the scene declares no Resting.
    """
    others = [h for h in world.forces if not (cluster[h.a] or cluster[h.b])]
    world.forces = others
    world.contacts = lasting if len(lasting.kinds) else None
    for island in islands(lasting, world.bodies) if len(lasting.kinds) else []:
        _stop_parting(world, island)
        pose = _pose(world)
        k = kinematics(island.contacts, pose.x, pose.rotation, pose.v, pose.w)
        try:
            p = push(island, pose, world.bodies, world.settings.solver, _guess(world, island))
        except NoSolution as error:
            raise Stalled(f"resting contact: {error}", world.t) from None
        world.audit.residual = max(world.audit.residual, p.residual)
        _require_resting(world, island, p.force)
        at_rest = _at_rest(world, island, p, pose)
        for i in island.bodies:
            world.mode[i] = STILL if at_rest else HELD
        if at_rest:
            shift_bodies(world.motion, world.bodies, island, pose, np.zeros(len(p.force)))
            for i in island.bodies:
                world.motion.v[i] = world.motion.L[i] = 0.0
                world.audit.rests += 1
        _record(world, island, k, p.force)
    if world.contacts is not None:
        keep = (world.mode[lasting.kinds[:, 0]] == HELD) | (world.mode[lasting.kinds[:, 1]] == HELD)
        world.contacts = lasting.chosen(keep) if keep.any() else None


def _guess(world: World, island: Island) -> np.ndarray | None:
    """Contacts that pushed a moment ago."""
    if not world.pushing:
        return None
    return np.array([_key(row) in world.pushing for row in island.contacts.kinds.tolist()])


def _key(row: list[int]) -> tuple[int, int, int, int]:
    return row[0], row[1], 8 * row[2] + row[3], row[4]


def _record(world: World, island: Island, k: Kinematics, force: np.ndarray) -> None:
    for row, f in enumerate(force.tolist()):
        whole = island.contacts.kinds[row].tolist()
        if f > 0.0:
            world.pushing.add(_key(whole))
            world.forces.append(
                Held(whole[0], whole[1], tuple(k.point[row].tolist()), tuple(k.normal[row].tolist()), f)
            )
        else:
            world.pushing.discard(_key(whole))


def _stop_parting(world: World, island: Island) -> None:
    """Take the last trace of normal velocity out of lasting contacts: the nearest motion without it, which has less energy."""
    b, m = world.bodies, world.motion
    pose = _pose(world)
    k = kinematics(island.contacts, pose.x, pose.rotation, pose.v, pose.w)
    if not k.rate.any():
        return
    g = island.rows(k, pose.x, pose.rotation, b)
    length = np.sqrt(np.einsum("ij,ij->i", g, g))
    change = -np.linalg.lstsq(g / length[:, None], k.rate / length, rcond=1e-10)[0].reshape(-1, 6)
    for at, i in enumerate(island.bodies):
        m.v[i] += change[at, :3] * math.sqrt(b.inverse_mass[i])
        m.L[i] += pose.rotation[i] @ (b.inertia[i] @ (b.root[i] @ change[at, 3:]))


def _require_resting(world: World, island: Island, force: np.ndarray) -> None:
    if world.parts.law.resting:
        return
    weight = max(
        float(np.linalg.norm(world.bodies.acceleration[i]) / world.bodies.inverse_mass[i]) for i in island.bodies
    )
    if force.max() > 1e-9 * weight:
        strongest = int(np.argmax(force))
        a, b = island.contacts.kinds[strongest, :2].tolist()
        raise MissingEffect("Resting", world.names(a, b), world.t, "bodies stay in contact")


def _at_rest(world: World, island: Island, p, pose: Pose) -> bool:  # noqa: ANN001
    """Whether nothing of the island moves or is about to, so that it stays as it is until something touches it."""
    b, s = world.bodies, world.scales
    partners = {i for i in island.contacts.kinds[:, :2].ravel().tolist() if b.inverse_mass[i] == 0.0}
    if any(not world.static(i) for i in partners):
        return False
    pull = s.speed / s.time
    for at, i in enumerate(island.bodies):
        reach = b.reach[i]
        if np.linalg.norm(pose.v[i]) + reach * np.linalg.norm(pose.w[i]) > REST_SPEED * s.speed:
            return False
        turn = reach * b.quickness[i] * np.linalg.norm(p.torque[at])
        if np.linalg.norm(p.acceleration[at]) + turn > REST_ACCELERATION * pull:
            return False
    return True
