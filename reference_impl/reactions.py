"""Forces that joints carry, computed when they are asked for.

With the accelerations known, what the loads and contacts do not account for is the joints': their scaled force is the
part of x - c - Gᵀ f in the motions that they take away, and the forces of the rows follow from it.  Where rows repeat
each other the split among them is not unique, and the smallest is given.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from reference_impl.collide.detect import kinematics
from reference_impl.effects.joint import AXIS, POINT
from reference_impl.effects.resting import Island, Pose, Problem, islands, push
from reference_impl.effects.sliding import grip_of, pressed, rough_push
from reference_impl.rough import limits
from reference_impl.world import World


class JointForce(NamedTuple):
    """What a rod or hinge does to body a; its opposite acts on b."""

    joint: int  # number among the rods and hinges of the scene, in its order, without those between fixed bodies
    a: int
    b: int
    point: tuple[float, float, float]  # the anchor of a, where the force acts [m]
    force: tuple[float, float, float]  # on a [N]
    torque: tuple[float, float, float]  # on a, beside that of the force [N m]


def joint_forces(world: World) -> list[JointForce]:
    """Forces of all rods and hinges now, in scene order; empty where there are none.

    Raises
    ------
    NoSolution
        If no contact forces exist now.
    """
    if world.links is None:
        return []
    pose, b = Pose.now(world.motion, world.bodies), world.bodies
    everything = world.links.free.copy()
    contacts = world.detector.contacts(pose.x, pose.rotation, everything)
    k = kinematics(contacts, pose.x, pose.rotation, pose.v, pose.w)
    contacts = contacts.chosen(np.abs(k.rate) <= world.search.parting)
    out: list[JointForce] = []
    for island in islands(contacts, b, world.links):
        if island.jointed:
            stuck = island.problem(pose, b).stuck()
            out += _of_island(world, island.part(~stuck), pose)
    return sorted(out)


def _of_island(world: World, island: Island, pose: Pose) -> list[JointForce]:
    problem, mu = island.problem(pose, world.bodies), world.mu[island.contacts.pairs]
    if mu.any():
        bounds = limits(world)
        grip = grip_of(island, problem, pose, world.bodies, mu, bounds)
        p, friction, _ = rough_push(island, problem, pose, world.bodies, grip, bounds.slow, pressed(grip))
    else:
        p = push(island, problem, pose, world.bodies, world.settings.solver)
        friction = np.zeros((len(p.force), 3))
    assert problem.space is not None
    assert problem.whole is not None
    assert problem.pulled is not None
    acting = problem.pulled + problem.whole.T @ p.force + _scaled(island, problem, pose, world, friction)
    return _wrenches(island, pose, problem.space.forces(problem.space.given - acting))


def _scaled(island: Island, problem: Problem, pose: Pose, world: World, force: np.ndarray) -> np.ndarray:
    """Scaled acceleration by forces (m, 3) [N] at the contacts."""
    b, out = world.bodies, np.zeros(6 * len(island.bodies))
    for row, pull in enumerate(force):
        for sign, i in zip((1.0, -1.0), island.contacts.kinds[row, :2].tolist(), strict=True):
            at = island.place[i]
            if at >= 0:
                torque = np.cross(problem.k.point[row] - pose.x[i], pull)
                out[6 * at : 6 * at + 3] += sign * np.sqrt(b.inverse_mass[i]) * pull
                out[6 * at + 3 : 6 * at + 6] += sign * (b.root[i].T @ (pose.rotation[i].T @ torque))
    return out


def _wrenches(island: Island, pose: Pose, multipliers: np.ndarray) -> list[JointForce]:
    """The rows' forces put together by joint."""
    assert island.links is not None
    sums: dict[int, tuple[int, int, np.ndarray, np.ndarray, np.ndarray]] = {}
    for whole, real, size in zip(*island.links.joints[:2], multipliers.tolist(), strict=True):
        kind, a, b, joint = whole.tolist()
        point, other = (pose.x[i] + pose.rotation[i] @ arm for i, arm in ((a, real[0:3]), (b, real[3:6])))
        _, _, _, force, torque = sums.setdefault(joint, (a, b, point, np.zeros(3), np.zeros(3)))
        if kind == AXIS:
            torque += size * np.cross(pose.rotation[a] @ real[6:9], pose.rotation[b] @ real[9:12])
        elif kind == POINT:
            force += size * real[6:9]
        else:
            force += size * (point - other) / np.linalg.norm(point - other)
    return [
        JointForce(joint, a, b, *(tuple(vector.tolist()) for vector in vectors))
        for joint, (a, b, *vectors) in sums.items()
    ]
