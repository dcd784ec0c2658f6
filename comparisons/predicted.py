"""The predicted-error ledger: what the scheme of an engine alone must cost, beside what was measured.

Time stepping.  A scheme whose positions run ahead of its velocities by `lead` (see `adapters.engine.lead`) adds up the
right velocities at the wrong ends of its steps: Σ h v_k is the integral of v plus lead (v(t) - v(0)), to second order.
In a uniform field that is exact: g t h/2 for semi-implicit Euler (Hairer, Lubich, Wanner, Geometric Numerical
Integration, 2nd ed., §I.1), and it shows in the energy as -m g·lead (v(t) - v(0)), although nothing is lost.

Contact.  A stepping scheme notices an impact up to a step late.  For balls dropped on a floor the scheme with an ideal
contact is played step by step (`comparisons.textbook`), which holds both errors.

Solver.  What is left beyond that is neither: the engine's solver, softness, damping or threshold.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.accuracy import calm, distance
from comparisons.energy import energy_scale, potential_energy
from comparisons.measurement import Case, Quantity
from comparisons.textbook import Drop, drop_of, mean_square_energy_error, stepped
from mechanics.effects import Gravity, Restitution, Rotation

STEPPING, LEFT = "predicted position error", "position error beyond time stepping"
CONTACT, SOLVER = "predicted position error with contact", "position error beyond contact"
ENERGY, SQUARE = "predicted energy error", "predicted mean square energy error"

QUANTITIES = {
    STEPPING: ("m", "position error by time stepping alone, |lead (v - v(0))| with the true velocities"),
    LEFT: ("m", "largest distance from the truth, away from impacts, when that is taken off"),
    CONTACT: ("m", "position error of the engine's scheme with an ideal contact, for balls dropped on a floor"),
    SOLVER: ("m", "largest distance from the motion of that scheme"),
    ENERGY: ("1", "largest change of energy that is seen because positions run ahead of velocities, as 'energy error'"),
    SQUARE: ("J2", "(M g h)² 2 g H/12, the mean square energy error of an elastic drop from the clearance H"),
}


def measure(case: Case) -> Iterator[Quantity]:
    """What can be predicted of a case; nothing for engines that tell positions and velocities of the same time.

    Such an engine has no error of first order, except that of contacts; where gravity acts alone its prediction is 0.
    """
    moved = _moved(case)
    if moved is None:
        return
    t = case.trajectory.t
    yield Quantity.worst(STEPPING, _longest(moved), "m", t)
    if not case.run.lead:
        return
    if case.scenario.truth is not None:
        rows = np.flatnonzero(calm(case))
        apart = distance(case.trajectory.x - np.nan_to_num(moved), case.scenario.truth(t).x)
        if len(rows):
            yield Quantity.worst(LEFT, apart[rows], "m", t[rows])
    if case.scene.needs <= {Gravity, Rotation, Restitution} and case.conserved.energy == "conserved":
        yield from _energy(case, moved)
    drop = drop_of(case.scene)
    if drop is not None:
        yield from _dropped(case, drop)


def _moved(case: Case) -> np.ndarray | None:
    """(T, n, 3) lead (v - v(0)) by the true velocities [m], NaN where these are not known; None where none is."""
    t, lead, fixed = case.trajectory.t, case.run.lead, [body.fixed for body in case.scene.bodies]
    if Gravity in case.scene.needs and case.scene.needs <= {Gravity, Rotation}:
        fall = lead * np.multiply.outer(t - t[0], case.scene.gravity)
        return np.where(np.array(fixed)[:, None], 0.0, fall[:, None])
    if case.scenario.truth is None or not lead:
        return None
    v = case.scenario.truth(t).v
    return np.asarray(lead * (v - v[0])) if not np.isnan(v).all() else None


def _longest(moved: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(np.nan_to_num(moved), axis=2).max(axis=1))


def _energy(case: Case, moved: np.ndarray) -> Iterator[Quantity]:
    """The energy that is seen to come and go, because potential energy is that of another time."""
    own = moved[:, list(case.scene.moving)]
    if np.isnan(own).any():
        return
    moving = case.moving
    seen = np.abs((own @ case.scene.gravity) @ moving.mass)
    scale = energy_scale(moving, potential_energy(moving, case.trajectory, until=case.scenario.duration))
    yield Quantity.worst(ENERGY, seen, "1", case.trajectory.t, scale)


def _dropped(case: Case, drop: Drop) -> Iterator[Quantity]:
    """Balls dropped on a floor against their own scheme with an ideal contact."""
    t, h = case.trajectory.t, 2.0 * abs(case.run.lead)
    gap, _ = stepped(drop, h, case.run.lead < 0.0, np.rint(t / h).astype(int))
    played = np.array(case.trajectory.x)
    own = list(case.scene.moving)
    played[:, own] = played[:1, own] + np.multiply.outer(gap - drop.clearance, drop.up)[:, None]
    if case.scenario.truth is not None:
        yield Quantity.worst(CONTACT, distance(played, case.scenario.truth(t).x), "m", t)
    yield Quantity.worst(SOLVER, distance(case.trajectory.x, played), "m", t)
    if drop.e == 1.0:
        yield Quantity(SQUARE, mean_square_energy_error(drop, h), "J2")
