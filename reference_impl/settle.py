"""What happens at an instant: impulses at contacts that approach, then who stays in contact with whom.

The classification by the normal relative velocity u of a touching contact is made here and nowhere else:

    colliding    u < -floor
    resting      up to a speed too small to part (or back within a moment)
    separating   above
"""

from __future__ import annotations

import numpy as np

from reference_impl import audit, lasting
from reference_impl.collide.detect import Contacts
from reference_impl.collisions import alone, collide
from reference_impl.contact_problem import NoSolution, solve
from reference_impl.course import Course
from reference_impl.effects.resting import Island, Pose, Problem, Push, islands, nearest, push, rounding
from reference_impl.errors import MissingEffect, Stalled
from reference_impl.record import Held
from reference_impl.rough import jam, rough_forces
from reference_impl.world import FLYING, HELD, STILL, World

RETURN = 5e-6  # a contact that is back within this time never parted [time scale]
RETURN_ALONE = 1e-8  # the same for a sphere with one contact
RETURN_CHATTER = 5e-3  # the same for a body whose contacts come and go too often to be followed
ROUNDING = 1e-13  # forces below this part of the scaled weight are none
FAINT = 1e-15  # a force that changes no speed within the time scale is rounding [mass, speed scale / time scale]
ULPS = 1e-15  # normal velocity that is the rounding of velocities
JAMS = 20  # impulses at one instant in place of forces
REST_SPEED = 1e-10  # [speed scale]
REST_ACCELERATION = 1e-9  # [speed scale / time scale]
REST_TIED = 1e-13  # both, of bodies that swing: their rest is a place, and small motions about it are motions


def settle(world: World) -> None:
    """Deal with every contact of the bodies that are dirty, and start their new motion.

    Raises
    ------
    Stalled
        If contact forces do not exist again and again.
    """
    world.kept.clear()
    cluster = world.dirty & (world.bodies.inverse_mass > 0.0)  # a floor does not tell one island of another
    contacts = _touching(world, cluster)
    before, lasted = audit.arrival(world, cluster), world.mode != FLYING
    _release(world, cluster)
    for island in islands(contacts, world.bodies, world.linked(cluster)):
        world.audit.events += int(len(island.contacts.kinds) > 0)
        for _ in range(JAMS):
            if _settled(world, island):
                break
            _release(world, island.place >= 0)
        else:
            raise Stalled(f"{JAMS} impulses in place of forces that do not exist (Painlevé)", world.t)
    for i in np.flatnonzero(cluster & (world.mode != HELD)):
        world.launch(i)
    audit.departure(world, cluster, before)
    audit.watch(world, cluster, lasted)
    world.forget(cluster)
    world.dirty[:] = False


def _release(world: World, cluster: np.ndarray) -> None:
    """Take these bodies (boolean) out of all lasting contact."""
    world.mode[cluster] = FLYING
    for course in world.courses:
        if course.kept is not None and cluster[course.members].any():
            world.kept[course.island.contacts.kinds.tobytes()] = course.kept
    world.forces = [h for h in world.forces if not (cluster[h.a] or cluster[h.b])]
    world.courses = [c for c in world.courses if not cluster[c.members].any()]
    world.lasts &= ~cluster[world.detector.pairs].any(axis=1)


def _touching(world: World, cluster: np.ndarray) -> Contacts:
    """Contacts of these bodies (boolean), of all that they touch and so on; every one of them is in the present now."""
    while True:
        rotation = Pose.now(world.motion, world.bodies).rotation
        contacts = world.detector.contacts(world.motion.x, rotation, cluster)
        tied = world.links is not None and world.links.spread(cluster)
        if not lasting.interrupt(world, cluster) and not tied:
            return contacts


def _settled(world: World, island: Island) -> bool:
    """Whether the contacts that touch each other are dealt with; False if an impulse has taken the place of forces."""
    problem = island.problem(Pose.now(world.motion, world.bodies), world.bodies)
    stuck = problem.stuck()
    if stuck.any():  # contacts that joints hold need no force, and have no rate
        island = island.part(~stuck)
        problem = island.problem(Pose.now(world.motion, world.bodies), world.bodies)
    world.audit.gap = min(world.audit.gap, float(problem.k.gap.min(initial=0.0)))
    if (problem.k.rate < -world.search.speed).any():
        collide(world, island, problem)
        problem = island.problem(Pose.now(world.motion, world.bodies), world.bodies)
    return _hold(world, island.part(_resting(world, island, problem)))


def _resting(world: World, island: Island, problem: Problem) -> np.ndarray:
    """Which contacts stay: not parting, or back at once."""
    stays = problem.k.rate <= world.search.parting
    if stays.all():
        return stays
    moment = RETURN_ALONE if alone(problem.g) else RETURN
    if audit.chatters(world, island.bodies):
        moment = RETURN_CHATTER
    return stays | (problem.k.rate <= 0.5 * problem.closing(stays) * moment * world.scales.time)


def _hold(world: World, stay: Island) -> bool:
    """Put bodies with lasting contacts and joints under their forces, or to rest; False if an impulse was due instead.

    Raises
    ------
    MissingEffect
        If contact forces are needed and the scene declares no Resting.
    """
    for island in islands(stay.contacts, world.bodies, stay.links):
        _stop_parting(world, island)
        pose = Pose.now(world.motion, world.bodies)
        problem = island.problem(pose, world.bodies)
        mu, friction = world.mu[island.contacts.pairs], None
        try:
            if mu.any():
                p, friction = rough_forces(world, island, problem, pose, mu)
            else:
                kept = world.kept.get(island.contacts.kinds.tobytes())
                p = push(island, problem, pose, world.bodies, world.settings.solver, _guess(world, island), kept)
        except NoSolution as error:
            if not mu.any():
                raise Stalled(f"resting contact: {error}", world.t) from None
            jam(world, island)
            return False
        world.audit.residual = max(world.audit.residual, p.residual)
        _require_resting(world, island, p.force)
        at_rest = _at_rest(world, island, p, pose)
        world.mode[island.bodies] = STILL if at_rest else HELD
        if at_rest:
            island.shift(world.motion, world.bodies, np.zeros(len(p.force)))
            world.motion.v[island.bodies] = world.motion.L[island.bodies] = 0.0
            world.rested[island.bodies] = True
            world.audit.rests = int(world.rested.sum())
        else:
            world.courses.append(Course(world, island, p))
            world.lasts[island.contacts.pairs] = True
        _record(world, island, problem, p.force, friction)
    return True


def _guess(world: World, island: Island) -> np.ndarray:
    """Contacts that pushed a moment ago; if none of them did, all: of several splits of the load the most even one."""
    known = np.array([_key(row) in world.pushing for row in island.contacts.kinds.tolist()], dtype=bool)
    return known if known.any() else ~known


def _key(row: list[int]) -> tuple[int, int, int, int]:
    return row[0], row[1], 8 * row[2] + row[3], row[4]


def _record(
    world: World, island: Island, problem: Problem, force: np.ndarray, friction: np.ndarray | None = None
) -> None:
    """Keep the forces; what is rounding beside the weight of the bodies is no force."""
    k = problem.k
    if not len(force):
        return
    along = np.zeros((len(force), 3)) if friction is None else friction
    least = ROUNDING * float(np.abs(problem.free).max()) / float(np.sqrt((problem.g**2).sum(axis=1)).min())
    for row, f in enumerate(force.tolist()):
        whole = island.contacts.kinds[row].tolist()
        if f > least:
            world.pushing.add(_key(whole))
            place, normal = tuple(k.point[row].tolist()), tuple(k.normal[row].tolist())
            world.forces.append(Held(whole[0], whole[1], place, normal, f, tuple(along[row].tolist())))
        else:
            world.pushing.discard(_key(whole))


def _stop_parting(world: World, island: Island) -> None:
    """Take the last trace of normal velocity out of lasting contacts; the nearest such motion has less energy.

    Not out of contacts that have just ceased to push: their slow parting is the begin of a flight.
    """
    pose = Pose.now(world.motion, world.bodies)
    problem = island.problem(pose, world.bodies)
    fastest = max(float(np.abs(pose.v[island.bodies]).max()), world.scales.speed)
    rate = problem.k.rate
    stays = ~((rate > ULPS * fastest) & _leaving(world, island, problem))
    if np.abs(rate[stays]).max(initial=0.0) > ULPS * fastest:
        island.change(world.motion, world.bodies, pose, nearest(problem.g, np.where(stays, -rate, 0.0)))


def _leaving(world: World, island: Island, problem: Problem) -> np.ndarray:
    """Which contacts open without a push; of several with friction none is known to."""
    opens = problem.closing(np.zeros(len(problem.g), dtype=bool)) < 0.0
    if not opens.any() or len(opens) == 1:
        return opens
    if world.mu[island.contacts.pairs].any():
        return np.zeros_like(opens)
    try:
        return opens & (solve(problem.g, problem.free, problem.least).f == 0.0)
    except NoSolution:
        return np.zeros_like(opens)


def _require_resting(world: World, island: Island, force: np.ndarray) -> None:
    if world.parts.law.resting:
        return
    weight = max(
        float(np.linalg.norm(world.bodies.acceleration[i]) / world.bodies.inverse_mass[i]) for i in island.bodies
    )
    mass = float((1.0 / world.bodies.inverse_mass[island.bodies]).max())
    force = np.where(island.contacts.pairs < world.detector.solid, force, 0.0)
    if force.max(initial=0.0) > max(1e-9 * weight, FAINT * mass * world.scales.speed / world.scales.time):
        strongest = int(np.argmax(force))
        a, b = island.contacts.kinds[strongest, :2].tolist()
        raise MissingEffect("Resting", world.names(a, b), world.t, "bodies stay in contact")


def _at_rest(world: World, island: Island, p: Push, pose: Pose) -> bool:
    """Whether nothing of the island moves or is about to, so that it stays as it is until something touches it."""
    b, s = world.bodies, world.scales
    if any(not world.static(i) for i in island.carriers(b)):
        return False
    tied = island.links is not None
    slow = REST_TIED if tied else REST_SPEED
    least = max(REST_TIED if tied else REST_ACCELERATION, 100.0 * rounding(b, island.bodies)) * s.speed / s.time
    for at, i in enumerate(island.bodies.tolist()):
        reach = b.reach[i]
        if np.linalg.norm(pose.v[i]) + reach * np.linalg.norm(pose.w[i]) > slow * s.speed:
            return False
        turn = reach * b.quickness[i] * np.linalg.norm(p.torque[at])
        if np.linalg.norm(p.acceleration[at]) + turn > least:
            return False
    return True
