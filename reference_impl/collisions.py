"""Impulses at the contacts of a world that approach, and when bounces that accumulate are over.

A contact whose restitution is e < 1 and whose gap closes with the constant acceleration a bounces infinitely often:
struck at the speed u, it comes to rest after 2 e u / (a (1 - e)).  Once that time is a small share of the scene's
own time scale, the contact is struck without restitution and lasts from then on.  It is the contact that passes to
rest, not the body: a box does this at one corner while the rest of it still moves.

A sphere on its own bounces until its bounces are lower than the rounding of its position.  Nothing of the motion is
lost then: what the remaining bounces would exchange along the normal, m (u + a t) up to the time t, is what the
contact force exchanges, and friction is in proportion.  The time of rest follows from any bounce, best from the first.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from reference_impl.audit import chatters, imbalance
from reference_impl.collide.features import CORD
from reference_impl.contact_problem import NoSolution
from reference_impl.effects.impact import LAWS, Collision, in_turn
from reference_impl.effects.resting import Island, Problem
from reference_impl.errors import MissingEffect, Stalled
from reference_impl.kernels import cross
from reference_impl.record import Collided
from reference_impl.rough import exchange_friction, rough_collision
from reference_impl.world import World

ACCUMULATION = 1e-3  # bounces of a body that would all happen within this time are skipped [time scale]
LAST_ALONE = 4e-8  # a shorter bounce of a sphere on its own is the last; 2e-16 of its size high [time scale]
SAME_REST = 1e-10  # times of rest foreseen at two bounces that differ by less are the same [time scale, or the time]
NOISE = 1e-14  # rounding of a gap [position]
GRAIN = 2.0**-52  # rounding of a coordinate, below which there is no bounce to be seen [position]


def alone(g: np.ndarray) -> bool:
    """Whether one contact of a body that it cannot turn is all there is: a sphere on its own."""
    return len(g) == 1 and not g[:, 3:6].any()


def collide(world: World, island: Island, problem: Problem) -> None:
    """Exchange impulses at the contacts that approach.

    Raises
    ------
    MissingEffect
        If bodies collide in a scene without Restitution.
    Stalled
        If no solver finds the impulses.
    """
    _require_restitution(world, island, problem)
    e, mu = _restitution(world, island, problem), world.mu[island.contacts.pairs]
    v, momentum = world.motion.v.copy(), world.motion.L.copy()
    law = LAWS[world.settings.impact_law]
    try:
        if mu.any():
            collision, tangents = rough_collision(world, island, problem, mu, e)
            outcome = (law if world.settings.restitution == "newton" else in_turn)(collision)
            impulses, along = outcome.impulses[:, 0], np.einsum("ij,ijk->ik", outcome.impulses[:, 1:], tangents)
        else:
            carried = world.moving or problem.space is not None
            drift = problem.k.rate - problem.g @ problem.motion if carried else np.zeros(len(mu))
            outcome = law(Collision(problem.g, problem.motion, drift, e, world.search.speed, world.audit.certified))
            impulses, along = outcome.impulses, np.zeros((len(mu), 3))
    except NoSolution as error:
        raise Stalled(f"impact: {error}", world.t) from None
    _exchange(world, island, problem, impulses)
    exchange_friction(world, island, problem, along)
    whole = impulses[:, None] * problem.k.normal + along
    audit = world.audit
    audit.passes = max(audit.passes, outcome.passes)
    if outcome.stopped:
        audit.stopped += 1
        world.report("stopped impact", *island.bodies.tolist())
    audit.imbalance = max(
        audit.imbalance,
        imbalance(world, island.bodies, island.contacts.kinds, problem.k.point, whole, v, momentum),
    )
    island.hold(world.motion, world.bodies)  # joints take their part


def _require_restitution(world: World, island: Island, problem: Problem) -> None:
    rate = np.where(island.contacts.pairs < world.detector.solid, problem.k.rate, 0.0)  # tethers have their own
    worst = int(np.argmin(rate))
    speed = -float(rate[worst])
    if world.parts.law.restitution is None and speed > world.search.parting:
        a, b = island.contacts.kinds[worst, :2].tolist()
        raise MissingEffect("Restitution", world.names(a, b), world.t, f"bodies collide at {speed:.6g} m/s")


def _restitution(world: World, island: Island, problem: Problem) -> Callable[[np.ndarray], np.ndarray]:
    """Coefficient of restitution of each contact when struck at normal velocities u (m,)."""
    e = world.restitution(island.contacts)
    if chatters(world, island.bodies):
        e[:] = 0.0
    closing = problem.closing(np.abs(problem.k.rate) <= world.search.parting)
    limit = ACCUMULATION * world.scales.time
    if alone(problem.g) and problem.space is None:
        found = float(problem.k.gap[0])
        return lambda u: _alone(world, int(island.bodies[0]), u, float(closing[0]), float(e[0]), found)
    # a body on one that lies still is pulled towards it though neither is in the sum of the loads
    pull = np.where(closing > 0.0, closing, world.scales.speed / world.scales.time)

    def of(u: np.ndarray) -> np.ndarray:
        left = np.full(len(u), math.inf)
        ends = (u < 0.0) & (closing > 0.0) & (e < 1.0)
        left[ends] = 2.0 * e[ends] * -u[ends] / (closing[ends] * (1.0 - e[ends]))
        lost = (e < 1.0) & _unseen(e * u, problem.k.gap, pull)
        return np.where(lost | (left < limit), 0.0, e)

    return of


def _unseen(speed: np.ndarray, gap: np.ndarray, pull: np.ndarray) -> np.ndarray:
    """Whether a bounce at `speed` [m/s] is not higher than the overlap at which the contact was found.

    The search for contacts may be late by its tolerance, and what it finds so has fallen as much too far: bounces as
    low as that would be kept alive by it.
    """
    return speed * speed <= 8.0 * pull * np.maximum(-gap, 0.0)


def _alone(world: World, body: int, u: np.ndarray, closing: float, e: float, gap: float) -> np.ndarray:
    """Coefficient of restitution (1,) of a sphere on its own; foresees its time of rest."""
    if not (closing > 0.0 and u[0] < 0.0 and 0.0 < e < 1.0):
        return np.full(1, e)
    bounce = 2.0 * e * -float(u[0]) / closing
    rest = world.t + bounce / (1.0 - e)
    away = float(np.abs(world.motion.x[body]).max())
    # a gap that is off by d shifts the speed of the bounce by a d / u, and so the time of rest by d / u (1 - e)
    noise = NOISE * away / (-float(u[0]) * (1.0 - e))
    same = SAME_REST * max(world.scales.time, rest) + noise
    if not abs(rest - world.foreseen[body]) <= same:  # NaN: foreseen for the first time
        world.foreseen[body] = rest
    # slower than twice what counts as parting the contact would seem to last, with its last impulses lost
    short = bounce < LAST_ALONE * world.scales.time or -e * float(u[0]) <= 2.0 * world.search.parting
    # found a rounding too late it arrives as fast again as it left, for ever
    if not short and not _unseen(e * u, np.full(1, min(gap, -GRAIN * away)), np.full(1, closing))[0]:
        return np.full(1, e)
    world.audit.last_bounce = float(world.foreseen[body])
    return np.zeros(1)


def _exchange(world: World, island: Island, problem: Problem, impulses: np.ndarray) -> None:
    """Add impulses along the normals to the motion, and put them on record."""
    b, m, k = world.bodies, world.motion, problem.k
    for row, p in enumerate(impulses.tolist()):
        if p == 0.0:
            continue
        ends = island.contacts.kinds[row, :2].tolist()
        n, point = k.normal[row], k.point[row]
        for sign, i in zip((p, -p), ends, strict=True):
            m.v[i] += sign * b.inverse_mass[i] * n
            central = b.radius[i] > 0.0 and island.contacts.kinds[row, 2] != CORD  # the normal of a sphere
            if b.quickness[i] > 0.0 and not central:
                m.L[i] += sign * cross(point - m.x[i], n)
        world.events.append(Collided(world.t, ends[0], ends[1], tuple(point.tolist()), tuple(n.tolist()), p))
        world.audit.impacts += 1
