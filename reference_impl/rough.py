"""Friction at an instant of a world: collisions, forces, and impulses where forces do not exist."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from reference_impl.contact_problem import NoSolution
from reference_impl.effects.friction import frames, rough, slips
from reference_impl.effects.resting import Island, Pose, Problem, Push, nearest
from reference_impl.effects.rough_impact import RoughCollision
from reference_impl.effects.sliding import Limits, grip_of, pressed, rough_push
from reference_impl.errors import Stalled
from reference_impl.friction_cone import HOLDS, OFF
from reference_impl.friction_problem import solve
from reference_impl.kernels import cross
from reference_impl.world import World

SLOW = 1e-10  # slip below which a contact counts as not sliding [speed scale]
BEGINS = 1e-9  # acceleration above which a contact begins to slide [speed scale / time scale]
CREEP = 1e-3  # slip up to which a contact is still beginning to slide [speed scale]
LAG = 1e-4  # time by which friction looks ahead there [time scale]
KICK = 1e-9  # time of the loads that start an impulse where forces do not exist [time scale]


def limits(world: World) -> Limits:
    """What counts as sliding in this scene."""
    speed, time = world.scales.speed, world.scales.time
    sides = world.settings.sides if world.settings.friction == "pyramid" else 0
    return Limits(SLOW * speed, BEGINS * speed / time, CREEP * speed, LAG * time, sides)


def rough_collision(
    world: World, island: Island, problem: Problem, mu: np.ndarray, e: Callable[[np.ndarray], np.ndarray]
) -> tuple[RoughCollision, np.ndarray]:
    """Contacts that collide with friction, and the tangents (m, 2, 3) of their impulses."""
    pose, m = Pose.now(world.motion, world.bodies), len(mu)
    s = slips(island.contacts, problem.k, pose, world.bodies)
    model = world.settings.friction
    # a polygon has its corners where the surface says; the circle may turn with the slip
    tangents = frames(problem.k.normal, np.zeros((m, 3)) if model == "pyramid" else s.velocity)
    rows = rough(island, problem, pose, world.bodies, tangents, mu, np.zeros(m, dtype=np.bool_)).g.reshape(m, 3, -1)
    drift = np.zeros((m, 3))
    if problem.space is not None:  # rows of the motions that joints leave free
        drift[:, 0] = problem.k.rate
        drift[:, 1:] = np.einsum("ijk,ik->ij", tangents, s.velocity)
        drift -= rows @ problem.motion
    elif world.moving:
        drift[:, 0] = np.einsum("ij,ij->i", problem.k.normal, s.carried)
        drift[:, 1:] = np.einsum("ijk,ik->ij", tangents, s.carried)
    choices = (model, world.settings.sides, world.settings.restitution, world.settings.tolerance)
    return RoughCollision(
        rows, problem.motion, drift, e, world.search.speed, world.audit.certified_friction, mu, *choices
    ), tangents


def exchange_friction(world: World, island: Island, problem: Problem, along: np.ndarray) -> None:
    """Add impulses along the surfaces (m, 3) [N s] to the motion."""
    b, m = world.bodies, world.motion
    for row, p in enumerate(along):
        if not p.any():
            continue
        for sign, i in zip((1.0, -1.0), island.contacts.kinds[row, :2].tolist(), strict=True):
            m.v[i] += sign * b.inverse_mass[i] * p
            if b.quickness[i] > 0.0:
                m.L[i] += sign * cross(problem.k.point[row] - m.x[i], p)


def rough_forces(world: World, island: Island, problem: Problem, pose: Pose, mu: np.ndarray) -> tuple[Push, np.ndarray]:
    """Contact forces and friction (m, 3) [N] now; the last trace of slip is taken out of contacts that hold.

    Raises
    ------
    NoSolution
        If there are no such forces.
    """
    b, bounds = world.bodies, limits(world)
    grip = grip_of(island, problem, pose, b, mu, bounds)
    p, friction, _ = rough_push(island, problem, pose, b, grip, bounds.slow, pressed(grip))
    holds = ~grip.slides & ~grip.creeps & (p.force > 0.0)
    if holds.any():
        s = slips(island.contacts, problem.k, pose, b)
        if s.velocity[holds].any():
            tangents = frames(problem.k.normal, np.zeros((len(mu), 3)))
            rows = rough(island, problem, pose, b, tangents, mu, grip.slides).g.reshape(len(mu), 3, -1)
            target = np.empty((len(mu), 3))
            target[:, 0] = -problem.k.rate
            target[:, 1:] = -np.einsum("ijk,ik->ij", tangents, s.velocity)
            keep = np.zeros((len(mu), 3), dtype=bool)
            keep[:, 0] = True
            keep[holds, 1:] = True
            island.change(world.motion, b, pose, nearest(rows[keep], target[keep]))
    return p, friction


def jam(world: World, island: Island) -> None:
    """Impulses where contact forces do not exist (Painlevé): the limit of a short time of the loads.

    Contacts that slide are brought to where forces exist again, mostly to a stop, without having approached:
    Genot and Brogliato, New results on Painlevé paradoxes, 1999.

    Raises
    ------
    Stalled
        If there are no such impulses either.
    """
    b, world.audit.painleve = world.bodies, world.audit.painleve + 1
    world.report("painleve", *island.contacts.kinds[0, :2].tolist())
    pose = Pose.now(world.motion, b)
    problem = island.problem(pose, b)
    mu = world.mu[island.contacts.pairs]
    collision, tangents = rough_collision(world, island, problem, mu, lambda u: np.zeros(len(u)))
    kick = KICK * world.scales.time * problem.free
    rows = collision.rows.reshape(3 * len(mu), -1)
    p = rough(island, problem, pose, b, tangents, mu, np.zeros(len(mu), dtype=np.bool_))
    try:
        p = p._replace(g=rows, c=problem.motion + kick, d=-collision.drift.ravel())
        answer = solve(p, collision.model, collision.sides, enough=collision.enough)
    except NoSolution as error:
        raise Stalled(f"impulses in place of forces: {error}", world.t) from None
    # without the loads' share the contacts that hold would slide by as much backwards
    after, keep = answer.x - kick, np.zeros((len(mu), 3), dtype=bool)
    keep[answer.states != OFF, 0] = True
    keep[answer.states == HOLDS, 1:] = True
    if keep.any():
        after = after + nearest(rows[keep.ravel()], -(rows @ after + collision.drift.ravel())[keep.ravel()])
    island.change(world.motion, b, pose, after - problem.motion)
