"""Lasting contact with friction: forces at contacts that slide, roll or hold.

A contact that slides has the friction µ f against its slip direction, and f >= 0, gap'' >= 0, f·gap'' = 0.  A
contact that does not has a force anywhere within the cone, and either its points keep moving together or they
begin to slide against the force (`friction_problem` at the level of accelerations).  Between events each contact
stays in one of the two classes, and a slip direction turns continuously.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from reference_impl.effects.friction import frames, rough, slips
from reference_impl.effects.resting import Island, Pose, Problem, Push, accelerations
from reference_impl.friction_cone import HOLDS, SLIPS
from reference_impl.friction_polygon import faces, within
from reference_impl.friction_problem import Answer, Rough, solve
from reference_impl.state import Bodies


class Limits(NamedTuple):
    """What counts as sliding."""

    slow: float  # slip below which a contact does not slide [m/s]
    begins: float  # acceleration above which it begins to [m/s2]
    creep: float  # slip up to which it is still beginning [m/s]
    lag: float  # see `grip_of` [s]
    sides: int = 0  # of the polygon in place of the circle of friction; 0: the circle


class Grip(NamedTuple):
    """Class of each contact of an island between two events."""

    mu: np.ndarray  # (m,)
    slides: np.ndarray  # (m,) bool
    way: np.ndarray  # (m, 3) slip direction where it slides
    creeps: np.ndarray  # (m,) bool: it begins to slide
    lag: float  # time by which the friction of one that begins to slide looks ahead [s]
    facet: Facet | None = None  # where the cone is a pyramid


class Facet(NamedTuple):
    """To which part of a polygon the slip of each contact belongs; see `friction_polygon`."""

    sides: int
    turn: np.ndarray  # (m,) direction of its friction in the polygon's tangents [rad]; 0 where it does not slide
    between: np.ndarray  # (m,) bool: midway between two corners

    def tangents(self, normal: np.ndarray) -> np.ndarray:
        """Both tangents (m, 2, 3) of each contact, the first against its friction."""
        own = frames(normal, np.zeros(normal.shape))
        c, s = np.cos(self.turn)[:, None], np.sin(self.turn)[:, None]
        return np.stack([c * own[:, 0] + s * own[:, 1], c * own[:, 1] - s * own[:, 0]], axis=1)

    def coefficients(self, mu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients of friction (m,) along the first tangent and, for contacts midway, across it."""
        half = np.pi / self.sides
        return np.where(self.between, np.cos(half), 1.0) * mu, np.where(self.between, np.sin(half), 0.0) * mu


def forces(island: Island, problem: Problem, pose: Pose, b: Bodies, grip: Grip, floor: float,
           guess: np.ndarray | None = None) -> tuple[Answer, Rough, np.ndarray, np.ndarray]:  # fmt: skip
    """Contact forces (m, 3) along normal and tangents, the rows they belong to, the tangents, and the slips.

    Parameters
    ----------
    floor : float
        Slip slower than this has the direction that `grip` says [m/s].
    guess : (m,) array of int, optional
        States of the contacts a moment ago.

    Raises
    ------
    NoSolution
        If there are no such forces (Painlevé) or no solver finds them.
    """
    s = slips(island.contacts, problem.k, pose, b)
    if grip.facet is None:
        speed = np.sqrt((s.velocity**2).sum(axis=1))
        way = np.where((grip.slides & (speed > floor))[:, None], s.velocity, grip.way)
        # past a reversal that is still to be located the force goes on smoothly
        way[(way * grip.way).sum(axis=1) < 0.0] *= -1.0
        tangents = frames(problem.k.normal, np.where(grip.creeps[:, None], s.velocity, way))
        p = rough(island, problem, pose, b, tangents, grip.mu, grip.slides)
    else:
        tangents = grip.facet.tangents(problem.k.normal)
        mu, across = grip.facet.coefficients(grip.mu)
        p = rough(island, problem, pose, b, tangents, mu, grip.slides)._replace(across=across)
    least = p.d.reshape(-1, 3).copy()
    least[:, 0] = problem.least
    ahead = s.bias + s.pulled
    if grip.creeps.any():
        ahead[grip.creeps] += s.velocity[grip.creeps] / grip.lag
    least[:, 1:] -= np.einsum("ijk,ik->ij", tangents, ahead)
    p = p._replace(c=problem.free, d=least.ravel())
    model, sides = ("exact", 4) if grip.facet is None else ("pyramid", grip.facet.sides)
    return solve(p, model, sides, guess), p, tangents, s.velocity


def pressed(grip: Grip) -> np.ndarray:
    """The guess that every contact pushes: of several splits of the load the most even one."""
    return np.where(grip.slides, SLIPS, HOLDS)


def grip_of(island: Island, problem: Problem, pose: Pose, b: Bodies, mu: np.ndarray, limits: Limits) -> Grip:
    """Which contacts slide, and which begin to.

    Where slip c grows from zero its direction follows the acceleration at a rate µ f / |c| that is too stiff to follow.
    There friction opposes the slip a moment ahead, c + lag c', which changes nothing where the direction is constant.
    """
    s = slips(island.contacts, problem.k, pose, b)
    speed = np.sqrt((s.velocity**2).sum(axis=1))
    moves = (speed > limits.slow) & (mu > 0.0)
    way = np.zeros_like(s.velocity)
    way[moves] = s.velocity[moves] / speed[moves, None]
    none = np.zeros(len(mu), dtype=np.bool_)
    grip = Grip(mu, moves | (mu == 0.0), way, none, limits.lag, _facet(problem, s.velocity, moves, limits))
    doubtful = (mu > 0.0) & (speed <= limits.creep)
    if not doubtful.any():
        return grip
    answer, _, tangents, _ = forces(island, problem, pose, b, grip, limits.slow, pressed(grip))
    start = np.sqrt((answer.u[:, 1:] ** 2).sum(axis=1))
    grows = (answer.u[:, 1:] * np.einsum("ijk,ik->ij", tangents, way)).sum(axis=1) > 0.0
    creeps = doubtful & (answer.r[:, 0] > 0.0) & np.where(moves, grows, start > limits.begins)
    facet = _facet(problem, s.velocity, moves & ~creeps, limits)
    return Grip(mu, grip.slides & ~creeps, way, creeps, limits.lag, facet)


def _facet(problem: Problem, velocity: np.ndarray, moves: np.ndarray, limits: Limits) -> Facet | None:
    if limits.sides == 0:
        return None
    slip = np.einsum("ijk,ik->ij", frames(problem.k.normal, np.zeros(velocity.shape)), velocity)
    turn, between = faces(slip, limits.sides, limits.slow)
    return Facet(limits.sides, np.where(moves, turn, 0.0), between & moves)


def rough_push(island: Island, problem: Problem, pose: Pose, b: Bodies, grip: Grip, floor: float,
               guess: np.ndarray | None = None) -> tuple[Push, np.ndarray, np.ndarray]:  # fmt: skip
    """Contact forces of an island with friction and the motion they cause; friction (m, 3) [N]; states of the contacts.

    Raises
    ------
    NoSolution
        If there are no such forces.
    """
    answer, _, tangents, _ = forces(island, problem, pose, b, grip, floor, guess)
    acceleration, torque = accelerations(island, answer.x, pose, b)
    friction = np.einsum("ij,ijk->ik", answer.r[:, 1:], tangents)
    return Push(answer.r[:, 0], acceleration, torque, answer.residual), friction, answer.states


def reversing(island: Island, problem: Problem, pose: Pose, b: Bodies, grip: Grip, loaded: np.ndarray) -> float:
    """Least slip along its first direction of the loaded contacts that slide [m/s]; inf if there is none.

    Of a pyramid: the least distance of a slip from where it belongs to another part of the polygon.
    """
    chosen = grip.slides & loaded & (grip.mu > 0.0)
    if not chosen.any():
        return np.inf
    s = slips(island.contacts, problem.k, pose, b)
    if grip.facet is not None:
        slip = np.einsum("ijk,ik->ij", grip.facet.tangents(problem.k.normal), s.velocity)
        return float(within(slip, grip.facet.between, grip.facet.sides)[chosen].min())
    return float((s.velocity * grip.way).sum(axis=1)[chosen].min())


def slip_of(island: Island, pose: Pose, b: Bodies) -> np.ndarray:
    """Velocities along the surface (m, 3) with which the contacts slide [m/s]."""
    return slips(island.contacts, island.problem(pose, b).k, pose, b).velocity


def stiffness(island: Island, pose: Pose, b: Bodies, grip: Grip, force: np.ndarray, ahead: np.ndarray) -> float:
    """Greatest rate at which friction turns a slip towards its course [1/s].

    A slip c that is off its course by δ across it is turned back by the friction µ f δ / |c| times what the contact
    yields to a force across it.

    Parameters
    ----------
    force : (m,) array
        Along the normals [N].
    ahead : (m, 3) array
        Slips a lag ahead, which friction opposes where contacts begin to slide [m/s].
    """
    problem = island.problem(pose, b)
    c = slips(island.contacts, problem.k, pose, b).velocity
    c[grip.creeps] = ahead[grip.creeps]
    speed = np.sqrt((c**2).sum(axis=1))
    moves = (grip.slides | grip.creeps) & (grip.mu > 0.0) & (force > 0.0) & (speed > 0.0)
    if not moves.any():
        return 0.0
    rows = rough(island, problem, pose, b, frames(problem.k.normal, c), grip.mu, grip.slides).g
    rates = grip.mu * force * (rows[2::3] ** 2).sum(axis=1)
    return float((rates[moves] / speed[moves]).max())
