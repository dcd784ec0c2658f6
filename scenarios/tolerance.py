"""Tolerances built from the first-order errors of time stepping.

A tolerance is what a careful user accepts at a step of 1 ms, the same for every engine.  It is never
chosen to let an engine pass: each is the textbook error of a first-order scheme on that very scene,
times one safety factor.  The terms, with h the step:

    g t h / 2    semi-implicit Euler falls this much too deep in time t (Hairer, Lubich and Wanner,
                 Geometric Numerical Integration, 2nd ed., §I.1)
    |Δv| h       a contact is seen up to one step late: a jump Δv of velocity then misplaces a body by this
    g h          by which a late impact is too fast
    v h          overlap of bodies that approach at v, before anything is noticed
    µ g h        change of speed by friction in one step: how sharply a step can see the stop
"""

from __future__ import annotations

from scenarios.scenario import Check

STEP = 1e-3  # [s]
SAFETY = 1.5
CONVERGED = 1e-3
GRAVITY = 9.81  # [m/s2]; what the effect `Gravity()` does


def first_order(quantity: str, error: float, unit: str, formula: str, exact: float = 1e-9) -> Check:
    """Check whose tolerance is a first-order `error` at a step of 1 ms times the safety factor.

    Parameters
    ----------
    quantity, exact
        As in `Check`.
    error : float
        [unit]
    formula : str
        What the error consists of, for people; becomes the check's reason together with the number.
    """
    size = f"{error:.3g} {unit}".removesuffix(" 1")
    return Check(quantity, SAFETY * error, f"{formula} = {size} at a step of 1 ms, times {SAFETY:g} for safety", exact)


def converged(quantity: str, scale: float, what: str, exact: float = 1e-9) -> Check:
    """Check of what no time step disturbs but an iterative solver may leave at 0.1 % of `scale`, named by `what`."""
    why = f"no step size enters here; a converged solver leaves at most 0.1 % of {what} ({scale:.3g})"
    return Check(quantity, CONVERGED * scale, why, exact)


def rounding(quantity: str, why: str, tolerance: float = 1e-9, exact: float = 1e-12) -> Check:
    """Check of what neither step size nor solver can disturb, for the reason `why`."""
    return Check(quantity, tolerance, f"{why}; what is left is rounding", exact)
