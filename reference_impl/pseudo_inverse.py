"""Small dense algebra in loops: products and the pseudo-inverse, without a library of linear algebra.

The matrices of a few contacts are smaller than what calling a library costs, and a compiled call of one makes every
process import scipy.linalg first, which takes a quarter of the time from nothing to the first step.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import kernel

SWEEPS = 40  # of rotations; the columns are orthogonal to rounding after six to ten
SQUARE = 1e-15  # cosine of two rows that counts as 0
VOID = 1e-28  # square of a row's length, over that of all, below which it counts as 0


@kernel
def times(a, b, out):
    """`out` = a b of a matrix (m, n) and a vector (n,)."""
    for i in range(a.shape[0]):
        total = 0.0
        for j in range(a.shape[1]):
            total += a[i, j] * b[j]
        out[i] = total


@kernel
def turned_times(a, b, out):
    """`out` = aᵀ b of a matrix (m, n) and a vector (m,)."""
    for j in range(a.shape[1]):
        total = 0.0
        for i in range(a.shape[0]):
            total += a[i, j] * b[i]
        out[j] = total


@kernel
def orthogonalise(w, v):
    """Turn the rows of `w`, and those of `v` along, until those of `w` are orthogonal; False for NaN or infinity.

    One-sided Jacobi: Golub and Van Loan, Matrix Computations, 4th ed., §8.6.3.
    """
    size = 0.0
    for i in range(w.shape[0]):
        for j in range(w.shape[1]):
            size += w[i, j] * w[i, j]
    if not math.isfinite(size):
        return False
    for _ in range(SWEEPS):
        still = True
        for i in range(w.shape[0] - 1):
            for j in range(i + 1, w.shape[0]):
                aa, bb, ab = 0.0, 0.0, 0.0
                for r in range(w.shape[1]):
                    aa += w[i, r] * w[i, r]
                    bb += w[j, r] * w[j, r]
                    ab += w[i, r] * w[j, r]
                if min(aa, bb) <= VOID * size or abs(ab) <= SQUARE * math.sqrt(aa * bb):
                    continue
                still = False
                cot = (bb - aa) / (2.0 * ab)
                tan = math.copysign(1.0, cot) / (abs(cot) + math.sqrt(1.0 + cot * cot))
                cosine = 1.0 / math.sqrt(1.0 + tan * tan)
                sine = tan * cosine
                for r in range(w.shape[1]):
                    w[i, r], w[j, r] = cosine * w[i, r] - sine * w[j, r], sine * w[i, r] + cosine * w[j, r]
                for r in range(v.shape[1]):
                    v[i, r], v[j, r] = cosine * v[i, r] - sine * v[j, r], sine * v[i, r] + cosine * v[j, r]
        if still:
            break
    return True


@kernel
def pseudo_inverse(a, rank, out):
    """`out` (n, m) = Moore-Penrose inverse of `a` (m, n); the columns' rank, or -1 for NaN or infinity.

    Singular values below `rank` times the largest count as 0.
    """
    m, n = a.shape
    w, v = a.T.copy(), np.eye(n)  # what is turned lies side by side in memory
    if not orthogonalise(w, v):
        return -1
    square = np.zeros(n)
    for j in range(n):
        for i in range(m):
            square[j] += w[j, i] * w[j, i]
    least = rank * rank * square.max() if n else 0.0
    out[:] = 0.0
    found = 0
    for j in range(n):
        if square[j] > least:
            found += 1
            for r in range(n):
                for i in range(m):
                    out[r, i] += v[j, r] * w[j, i] / square[j]
    return found
