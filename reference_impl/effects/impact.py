"""Impulses at colliding contacts.

Bodies a and b touch.  The unit normal n points from b to a, so they approach when the normal relative
velocity u = n·(v_a - v_b) of the touching points is negative.  An impulse p >= 0 acts along n on a and
against n on b.

One contact obeys Newton's law u⁺ = -e u⁻.  Where several touch at the same instant, rigid-body
mechanics alone does not decide; each `LAWS` entry is one answer, by name.  For one smooth contact they are all the
same.  None makes energy while all contacts have the same e; where e differs, `simultaneous` and `poisson` may.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from reference_impl.contact_problem import solve
from reference_impl.effects.rough_impact import RoughCollision

PASSES = 60  # of simultaneous impulses at one instant, before what still approaches stops dead
ALONG = 4  # for each contact, where nothing is lost: a row of 200 balls whose masses differ by up to 100 takes 3.3
TURNS = 10  # of each contact, after which those without restitution stop at once: their turns go on for ever


def normal_impulse(u: float, mobility: float, restitution: float) -> float:
    """Magnitude of the frictionless impulse that makes two bodies bounce [N s].

    Newton's law u⁺ = -e u⁻ and the linear response u⁺ = u⁻ + p K give

        p = -(1 + e) u⁻ / K,    K = 1/m_a + 1/m_b + (r_a × n)·I_a⁻¹(r_a × n) + (r_b × n)·I_b⁻¹(r_b × n),

    with the arms r from the centres of mass to the contact.  Separating bodies get no impulse.
    Baraff, Rigid Body Simulation II, SIGGRAPH course notes (1997), section 8.

    Parameters
    ----------
    u : float
        Normal relative velocity before [m/s].
    mobility : float
        K, the normal velocity gained per unit impulse [1/kg]: the square of the scaled contact row.
    """
    return -(1.0 + restitution) * u / mobility if u < 0.0 else 0.0


class Collision(NamedTuple):
    """Contacts of one instant in scaled coordinates: u = G y + drift for the scaled motion y."""

    rows: np.ndarray  # (m, k) G = J M^-1/2
    motion: np.ndarray  # (k,) scaled velocities before
    drift: np.ndarray  # (m,) what fixed bodies that move add to u [m/s]
    e: Callable[[np.ndarray], np.ndarray]  # u (m,) -> coefficient of restitution of each contact (m,)
    floor: float  # slower approach counts as none [m/s]
    certified: Callable[[float], None] = lambda residual: None  # is told the certificate of every contact problem

    def speeds(self, impulses: np.ndarray) -> np.ndarray:
        """Normal relative velocities u after `impulses` [m/s]."""
        return self.rows @ (self.motion + self.rows.T @ impulses) + self.drift

    def nothing(self) -> np.ndarray:
        """No impulses."""
        return np.zeros(len(self.drift))

    def bounce(self, impulses: np.ndarray, chosen: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Impulses added at once at the `chosen` contacts: p >= 0, u⁺ >= -e u⁻, p (u⁺ + e u⁻) = 0.

        One contact has a closed form; several are a contact problem.
        """
        out = self.nothing()
        rows = self.rows[chosen]
        u = self.speeds(impulses)[chosen]
        if len(u) == 1:
            out[chosen] = normal_impulse(float(u[0]), float(rows[0] @ rows[0]), float(e[chosen][0]))
            return out
        meant = rows.any(axis=0)  # of a long row of bodies a few coordinates
        rows, now = rows[:, meant], (self.motion + self.rows.T @ impulses)[meant]
        factor = 1.0 + e[chosen]
        every = np.ones(len(u), dtype=bool)  # the guess that all push: of the splits that are possible, the most even
        if np.all(factor == factor[0]):  # then u⁺ + e u⁻ = G (y⁺ + e y⁻) + (1 + e) drift
            answer = solve(rows, factor[0] * now, -factor[0] * self.drift[chosen], guess=every)
        else:
            answer = solve(rows, np.zeros(rows.shape[1]), -factor * u, guess=every)
        out[chosen] = answer.f
        self.certified(answer.residual)
        return out


Meeting = Collision | RoughCollision


class Outcome(NamedTuple):
    """What a law makes of a collision."""

    impulses: np.ndarray  # (m,) summed over all passes [N s]; (m, 3) with friction
    passes: int  # solves it took
    stopped: bool = False  # whether the passes ran out, and what still approached stopped dead


def stop(collision: Meeting, impulses: np.ndarray) -> np.ndarray:
    """Impulses added so that nothing approaches any more and nothing bounces (e = 0 at every contact)."""
    everything = np.ones(len(impulses), dtype=bool)
    return collision.bounce(impulses, everything, np.zeros(len(impulses)))


def propagation(collision: Meeting) -> Outcome:
    """Simultaneous impulses at all approaching contacts, repeated until none approaches.

    For e = 1 these are the generalised reflections of Smith, Kaufman, Vouga, Tamstorf and Grinspun
    (Reflections on simultaneous impact, SIGGRAPH 2012); for bodies in a line, the limit of small gaps.
    Contacts without any restitution are solved at once, which is where the repetition would lead.  Where energy is
    lost the passes may go on for ever, ever weaker; those in which a front reaches a contact for the first time are
    not counted, nor are elastic ones, which come to an end.
    """
    impulses = collision.nothing()
    m, left = len(impulses), PASSES
    struck = np.zeros(m, dtype=bool)
    most = PASSES + ALONG * m
    for passes in range(most):
        u = collision.speeds(impulses)
        chosen = u < -collision.floor
        if not chosen.any():
            return Outcome(impulses, passes)
        e = collision.e(u)
        if not e[chosen].any():
            chosen = np.ones(len(u), dtype=bool)
            e = np.zeros(len(u))
        if e[chosen].min() < 1.0 and struck[chosen].all():
            left -= 1
        if left < 0:
            return Outcome(impulses + stop(collision, impulses), passes + 1, True)
        struck |= chosen
        impulses = impulses + collision.bounce(impulses, chosen, e)
    return Outcome(impulses + stop(collision, impulses), most + 1, True)


def sequential(collision: Meeting) -> Outcome:
    """One contact at a time, the fastest approach first, until none approaches.

    Of equally fast ones the first in scene order: the result of a symmetric impact is not symmetric.
    Baraff, SIGGRAPH course notes (1997), section 8, treats collisions in this way.  Turns without any restitution
    converge geometrically; once they do nothing else, one solve ends them.
    """
    m = len(collision.drift)
    impulses = collision.nothing()
    most = 200 * m + 2000
    for passes in range(most):
        u = collision.speeds(impulses)
        # rounding must not choose between equal speeds
        first = int(np.argmax(u <= float(u.min()) * (1.0 - 1e-9)))
        if u[first] >= -collision.floor:
            return Outcome(impulses, passes)
        e = collision.e(u)
        if passes >= TURNS * m and not e[u < -collision.floor].any():
            return Outcome(impulses + stop(collision, impulses), passes + 1)
        chosen = np.zeros(m, dtype=bool)
        chosen[first] = True
        impulses = impulses + collision.bounce(impulses, chosen, e)
    return Outcome(impulses + stop(collision, impulses), most + 1, True)


def simultaneous(collision: Meeting) -> Outcome:
    """All contacts at once: 0 <= p, u⁺ + e u⁻ >= 0, p·(u⁺ + e u⁻) = 0 with the u⁻ of before the impact.

    Baraff, Analytical methods for dynamic simulation of non-penetrating rigid bodies, SIGGRAPH 1989;
    Moreau's law.  A contact that was separating may approach afterwards, so this too is repeated.
    """
    m = len(collision.drift)
    impulses = collision.nothing()
    everything = np.ones(m, dtype=bool)
    for passes in range(PASSES):
        u = collision.speeds(impulses)
        if not (u < -collision.floor).any():
            return Outcome(impulses, passes)
        impulses = impulses + collision.bounce(impulses, everything, collision.e(u))
    return Outcome(impulses + stop(collision, impulses), PASSES + 1, True)


def poisson(collision: Collision) -> Outcome:
    """Poisson's hypothesis for all contacts at once: what compression took as impulse, e times as much comes back.

    Compression ends where nothing approaches, 0 <= c, u >= 0, c·u = 0.  Expansion gives each contact at least e c,
    and more only where it would otherwise approach again: p >= e c, u⁺ >= 0, (p - e c)·u⁺ = 0.
    Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 8; here without friction.
    """
    impulses = collision.nothing()
    if not (collision.speeds(impulses) < -collision.floor).any():
        return Outcome(impulses, 0)
    compression = stop(collision, impulses)
    # a contact that did not approach itself, but was squeezed by others, bounces as if struck at this speed
    struck = -compression * np.einsum("ij,ij->i", collision.rows, collision.rows)
    impulses = (1.0 + collision.e(struck)) * compression
    if (collision.speeds(impulses) < -collision.floor).any():
        return Outcome(impulses + stop(collision, impulses), 2)
    return Outcome(impulses, 1)


def reflections(collision: Meeting) -> Outcome:
    """A blend of the elastic and the inelastic impact, y⁺ = e y_elastic + (1 - e) y_inelastic.

    y_elastic are the generalised reflections of Smith, Kaufman, Vouga, Tamstorf and Grinspun (Reflections on
    simultaneous impact, SIGGRAPH 2012), y_inelastic stops every approach at once.  Nothing approaches in either, and
    no mixture has more energy than both, so the blend keeps what they keep.  It has one e for all contacts.

    There is another extension to e < 1, that of the authors' program SCISim: Newton's law in each reflection, which
    is `propagation` here.  In a row of balls the two differ.
    """
    impulses = collision.nothing()
    u = collision.speeds(impulses)
    approaching = u < -collision.floor
    if len(u) == 1 or not approaching.any():
        return propagation(collision)
    e = float(collision.e(u)[approaching].max())
    inelastic = stop(collision, impulses)
    if e == 0.0:
        return Outcome(inelastic, 1)
    elastic = propagation(collision._replace(e=lambda u: np.ones(len(u))))
    return Outcome(e * elastic.impulses + (1.0 - e) * inelastic, elastic.passes + 1, elastic.stopped)


def in_turn(collision: RoughCollision) -> Outcome:
    """One rough contact at a time, the fastest approach first, each through compression and expansion (`phases`).

    These are differential laws of a single contact, whatever law says how several share an impact: where several
    approach, they have their turn as in `sequential`.  Once none of those that approach has any restitution, all stop
    at once; one contact on its own is followed through its compression even then.
    """
    m = len(collision.drift)
    impulses = collision.nothing()
    most = 200 * m + 2000
    for passes in range(most):
        u = collision.speeds(impulses)
        first = int(np.argmax(u <= float(u.min()) * (1.0 - 1e-9)))
        if u[first] >= -collision.floor:
            return Outcome(impulses, passes)
        e = collision.e(u)
        if m > 1 and not e[u < -collision.floor].any():
            return Outcome(impulses + stop(collision, impulses), passes + 1)
        impulses[first] += collision.strike(impulses, first, float(e[first]))
    return Outcome(impulses + stop(collision, impulses), most + 1, True)


LAWS: dict[str, Callable[[Meeting], Outcome]] = {
    "propagation": propagation,
    "sequential": sequential,
    "simultaneous": simultaneous,
    "poisson": poisson,
    "reflections": reflections,
}
