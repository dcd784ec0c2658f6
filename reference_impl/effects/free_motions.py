"""Motions that the rows of joints leave free, by turning the coordinates until those that joints take come first.

With the rows J of unit length in scaled coordinates, Jᵀ = Q R for a product Q of Householder's reflections and a
triangle R (Golub and Van Loan, Matrix Computations, 5.2).  The first coordinates of Qᵀ x are what the joints take of
x, the others are free, and the least acceleration that satisfies them is Q R⁻ᵀ target.  Nothing is squared.

A reflection touches only the coordinates from its own number to the last one of its row's bodies, and only rows that
share some of them.  For n links of a chain, numbered along it, that makes n² operations and not n³.

Rows that repeat each other (closed loops) have no triangle; their singular vectors take its place.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from reference_impl.kernels import inlined, lean

RANK = 1e-10  # relative singular value below which rows repeat each other
DOUBT = 1e-7  # what is left of a row beside those before it, below which the singular values decide


class Rows(NamedTuple):
    """Where r rows stand and how they move."""

    j: np.ndarray  # (r, 6 bodies) rows J M^-1/2
    gap: np.ndarray  # (r,) [m], angle for AXIS
    rate: np.ndarray  # (r,) gap'
    target: np.ndarray  # (r,) J times acceleration at which gap'' is zero


class Turned(NamedTuple):
    """What independent rows leave free."""

    given: np.ndarray  # (k,) least acceleration that satisfies the rows
    order: np.ndarray  # (r,) of the rows, in which they were eliminated
    length: np.ndarray  # (r,) of the rows as given, in that order
    rows: np.ndarray  # (r, k) row j: of the triangle Rᵀ up to its diagonal, then Householder's vector
    diagonal: np.ndarray  # (r,) of R
    last: np.ndarray  # (r,) end of Householder's vectors

    def within(self, motions: np.ndarray) -> np.ndarray:
        """The free part of one motion (k,) or of several (m, k)."""
        left = motions.reshape(-1, motions.shape[-1]).copy()
        _keep_free(self.rows, self.last, left)
        return left.reshape(motions.shape)

    def forces(self, motion: np.ndarray) -> np.ndarray:
        """Forces of the rows (r,) that make up the part of a scaled force (k,) which is not free."""
        r, turned = len(self.rows), motion.copy()
        for j, end in enumerate(self.last.tolist()):
            vector = self.rows[j, j:end]
            turned[j:end] -= (vector @ turned[j:end]) * vector
        triangle = np.tril(self.rows[:, :r], -1) + np.diag(self.diagonal)
        out = np.empty(r)
        out[self.order] = np.linalg.solve(triangle.T, turned[:r]) / self.length
        return out


class Spanned(NamedTuple):
    """What rows leave free that may repeat each other."""

    given: np.ndarray  # (k,) least acceleration that satisfies the rows
    basis: np.ndarray  # (rank, k) orthonormal: what they take
    back: np.ndarray  # (r, rank) forces of the rows from the part of a scaled force along the basis

    def within(self, motions: np.ndarray) -> np.ndarray:
        """The free part of one motion (k,) or of several (m, k); a second pass takes out what rounding left."""
        left = motions - (motions @ self.basis.T) @ self.basis
        return left - (left @ self.basis.T) @ self.basis

    def forces(self, motion: np.ndarray) -> np.ndarray:
        """Forces of the rows (r,) that make up the part of a scaled force (k,) which is not free; the smallest."""
        return self.back @ (self.basis @ motion)


Space = Turned | Spanned


def space(j: np.ndarray, target: np.ndarray) -> Space:
    """The motions that rows J (r, k) leave free, and the least one x with J x = target (r,), as far as there is one."""
    length = np.sqrt(np.einsum("ij,ij->i", j, j))
    if len(j) == 1:
        unit = j / length[0]
        return Spanned(unit[0] * (target[0] / length[0]), unit, np.array([[1.0 / length[0]]]))
    if len(j) <= j.shape[1]:
        turned = _turned(j, target, length)
        if turned is not None:
            return turned
    unit = j / length[:, None]
    u, s, vt = np.linalg.svd(unit, full_matrices=False)
    rank = int((s > RANK * s[0]).sum())
    u, s, vt = u[:, :rank], s[:rank], vt[:rank]
    return Spanned(vt.T @ ((u.T @ (target / length)) / s), vt, (u / s) / length[:, None])


def _turned(j: np.ndarray, target: np.ndarray, length: np.ndarray) -> Turned | None:
    """By reflections, the rows in the order of the last body they end on; None if rows may repeat each other."""
    width = j.shape[1]
    there = j != 0.0
    first, last = there.argmax(axis=1), width - there[:, ::-1].argmax(axis=1)
    order = np.argsort(last, kind="stable")
    first, last, length = first[order], last[order], length[order]
    rows, diagonal, given = j[order] / length[:, None], np.empty(len(j)), np.zeros(width)
    if not _eliminate(rows, first, last, target[order] / length, diagonal, given):
        return None
    return Turned(given, order, length, rows, diagonal, last)


@lean
def _eliminate(rows, first, last, target, diagonal, given):
    """Turn rows of unit length into `Turned.rows`; False once one is too near to a sum of those before it.

    `first` and `last`: where each row has its numbers; `last` does not decrease.
    """
    r = len(rows)
    for j in range(r):
        end, square = last[j], 0.0
        for c in range(j, end):
            square += rows[j, c] ** 2
        size = math.sqrt(square)
        if not size > DOUBT:
            return False
        diagonal[j] = -math.copysign(size, rows[j, j])
        rows[j, j] -= diagonal[j]
        scale = 1.0 / math.sqrt(size * abs(rows[j, j]))
        for c in range(j, end):
            rows[j, c] *= scale
        for i in range(j + 1, r):
            if first[i] < end:
                _reflect(rows[j], j, end, rows[i])
    for i in range(r):
        total = target[i]
        for j in range(i):
            total -= rows[i, j] * given[j]
        given[i] = total / diagonal[i]
    for j in range(r - 1, -1, -1):
        _reflect(rows[j], j, last[j], given)
    return True


@lean
def _keep_free(rows, last, motions):
    """Take what the joints take out of motions (m, k); a second pass takes out what rounding left."""
    r = len(rows)
    for k in range(2 * len(motions)):
        motion = motions[k // 2]
        for j in range(r):
            _reflect(rows[j], j, last[j], motion)
        for j in range(r):
            motion[j] = 0.0
        for j in range(r - 1, -1, -1):
            _reflect(rows[j], j, last[j], motion)


@inlined
def _reflect(vector, begin, end, motion):
    along = 0.0
    for c in range(begin, end):
        along += vector[c] * motion[c]
    for c in range(begin, end):
        motion[c] -= along * vector[c]
