"""Solvers of the contact problem with friction.

`friction_problem` tells what the problem is, chooses among these and certifies what they return.  Here normal
rows have unit length, forces are (3 m,) arrays (normal, tangent, tangent of each contact), and NaN says that a
solver gave up.  Every loop has a budget.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import kernel

ITERATIONS = 40  # of Newton's method
PIVOTS = 60  # per unknown, of Lemke's method
RELAXATIONS = 3_000
OFF, HOLDS, SLIPS = 0, 1, 2  # states of a contact
RANK = 1e-12  # relative singular value below which contacts count as redundant
SPLITS = 30  # of the load between redundant contacts that are tried


@kernel
def project(n, a, b, mu):
    """Nearest point to (n, a, b) in the cone |(a, b)| <= mu n."""
    t = math.sqrt(a * a + b * b)
    if t <= mu * n:
        return n, a, b
    if mu * t <= -n:
        return 0.0, 0.0, 0.0
    top = (n + mu * t) / (1.0 + mu * mu)
    return top, mu * top * a / t, mu * top * b / t


@kernel
def rate(u, r, mu, slides, convex):
    """Greatest component of r - P_K(r - u - µ|u_T| n) over all contacts; |min(f, u_n)| where a contact slides."""
    worst = 0.0
    for i in range(len(mu)):
        n, a, b = r[3 * i], r[3 * i + 1], r[3 * i + 2]
        if slides[i]:
            worst = max(worst, abs(min(n, u[3 * i])), abs(a + mu[i] * n), abs(b))
            continue
        more = 0.0 if convex else mu[i] * math.sqrt(u[3 * i + 1] ** 2 + u[3 * i + 2] ** 2)
        p, q, s = project(n - u[3 * i] - more, a - u[3 * i + 1], b - u[3 * i + 2], mu[i])
        worst = max(worst, abs(n - p), abs(a - q), abs(b - s))
    return worst


@kernel
def _solve3(w, alpha, q, out):
    """Solution of (w + diag(0, α, α)) out = -q by elimination of the symmetric matrix."""
    a, b, c = w[0, 0], w[0, 1], w[0, 2]
    d, e, f = w[1, 1] + alpha, w[1, 2], w[2, 2] + alpha
    c00, c01, c02 = d * f - e * e, c * e - b * f, b * e - c * d
    det = a * c00 + b * c01 + c * c02
    c11, c12, c22 = a * f - c * c, b * c - a * e, a * d - b * b
    out[0] = -(c00 * q[0] + c01 * q[1] + c02 * q[2]) / det
    out[1] = -(c01 * q[0] + c11 * q[1] + c12 * q[2]) / det
    out[2] = -(c02 * q[0] + c12 * q[1] + c22 * q[2]) / det


@kernel
def single(w, q, mu, out):
    """Exact solution for one contact, u = w r + q: off, held, or slipping.

    Slip is u_T = -α r_T for some α > 0, so r(α) = -(w + diag(0, α, α))⁻¹ q, and α is where |r_T| = µ r_n:
    positive at α = 0 (else the contact holds), negative for large α, where r_n -> -q_n / w_nn > 0.
    """
    if q[0] >= 0.0:
        out[:] = 0.0
        return
    if mu == 0.0:
        out[0], out[1], out[2] = -q[0] / w[0, 0], 0.0, 0.0
        return
    scale = w[1, 1] + w[2, 2]
    det = w[1, 1] * w[2, 2] - w[1, 2] ** 2
    if scale <= 1e-30:
        out[0], out[1], out[2] = -q[0] / w[0, 0], 0.0, 0.0
        return
    _solve3(w, 1e-15 * scale if det <= 1e-14 * scale * scale else 0.0, q, out)
    excess = math.sqrt(out[1] ** 2 + out[2] ** 2) - mu * out[0]
    if excess <= 0.0 and math.isfinite(excess):
        return
    low, high = 0.0, scale
    f_low, f_high = excess, 1.0
    for _ in range(200):
        _solve3(w, high, q, out)
        f_high = math.sqrt(out[1] ** 2 + out[2] ** 2) - mu * out[0]
        if f_high <= 0.0:
            break
        low, f_low = high, f_high
        high *= 4.0
    side = 0
    for _ in range(100):
        if high - low <= 1e-16 * high:
            break
        middle = (low * f_high - high * f_low) / (f_high - f_low)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        _solve3(w, middle, q, out)
        f = math.sqrt(out[1] ** 2 + out[2] ** 2) - mu * out[0]
        if f == 0.0:
            break
        if f > 0.0:
            low, f_low = middle, f
            if side == 1:
                f_high *= 0.5
            side = 1
        else:
            high, f_high = middle, f
            if side == -1:
                f_low *= 0.5
            side = -1
        if abs(f) <= 1e-16 * mu * abs(out[0]):
            break
    t = math.sqrt(out[1] ** 2 + out[2] ** 2)
    if t > 0.0:
        out[1], out[2] = mu * out[0] * out[1] / t, mu * out[0] * out[2] / t


@kernel
def _single_convex(w, q, mu, out):
    """The same without the term µ |u_T| n: projected gradients from `out` on."""
    step = 1.0 / (w[0, 0] + w[1, 1] + w[2, 2])
    for _ in range(500):
        u0 = q[0] + w[0, 0] * out[0] + w[0, 1] * out[1] + w[0, 2] * out[2]
        u1 = q[1] + w[1, 0] * out[0] + w[1, 1] * out[1] + w[1, 2] * out[2]
        u2 = q[2] + w[2, 0] * out[0] + w[2, 1] * out[1] + w[2, 2] * out[2]
        n, a, b = project(out[0] - step * u0, out[1] - step * u1, out[2] - step * u2, mu)
        change = abs(n - out[0]) + abs(a - out[1]) + abs(b - out[2])
        out[0], out[1], out[2] = n, a, b
        if change <= 1e-16 * abs(n):
            break


@kernel
def hold(g, c, d, mu, modes, way, r, x):
    """Forces into `r` and motion into `x` (at first 0 and c) that hold what `modes` say at zero; False if none do.

    Of several splits of the load the smallest in the mean square, with no contact that slips pulling.  Where
    redundant contacts slide in different directions the motion depends on the split, so this one is a choice; it
    depends continuously on the state.
    """
    m, k = len(mu), g.shape[1]
    index = np.empty(3 * m, dtype=np.int64)
    q = 0
    for i in range(m):
        for a in range(3):
            if modes[i] == HOLDS or (modes[i] == SLIPS and a == 0):
                index[q] = 3 * i + a
                q += 1
    if q == 0:
        return True
    rows, columns, least = np.empty((q, k)), np.empty((q, k)), np.empty(q)
    limited = np.zeros(q, dtype=np.bool_)
    some = False
    for e in range(q):
        at = index[e]
        i = at // 3
        least[e] = d[at]
        rows[e] = g[at]
        columns[e] = g[at]
        if modes[i] == SLIPS:
            limited[e] = some = True
            for j in range(k):
                columns[e, j] -= mu[i] * (way[i, 0] * g[at + 1, j] + way[i, 1] * g[at + 2, j])
    force = np.zeros(q)
    if some:
        matrix = rows @ columns.T
        chosen = np.ones(q, dtype=np.bool_)
        done = False
        inverse = np.zeros((q, q))
        for _ in range(SPLITS):
            part = matrix.copy()
            for e in range(q):
                if not chosen[e]:
                    part[:, e] = 0.0
            u, s, vt = np.linalg.svd(part)
            regular = s[q - 1] > RANK * s[0]
            for e in range(q):
                s[e] = 1.0 / s[e] if s[e] > RANK * s[0] else 0.0
            inverse = np.ascontiguousarray((vt.T * s) @ u.T)
            if regular:
                done = True
                break
            # least norm: force = (matrixᵀ y)₊ on the limited ones
            y = inverse.T @ (inverse @ (least - rows @ c))
            pull = matrix.T @ y
            change = False
            size = np.abs(pull).max()
            for e in range(q):
                wanted = not limited[e] or pull[e] > -1e-14 * size
                if wanted != chosen[e]:
                    chosen[e] = wanted
                    change = True
            if not change:
                done = True
                break
        if not done:
            return False
        for _ in range(3):
            step = inverse @ (least - rows @ x)
            force += step
            x += columns.T @ step
    else:
        u, s, vt = np.linalg.svd(rows, False)
        rank = 0
        for e in range(len(s)):
            rank += s[e] > RANK * s[0]
        u, s, vt = np.ascontiguousarray(u[:, :rank]), s[:rank], np.ascontiguousarray(vt[:rank])
        for _ in range(2):
            step = (u.T @ least) / s - vt @ x
            force += u @ (step / s)
            x += vt.T @ step
    for e in range(q):
        at = index[e]
        i = at // 3
        r[at] = force[e]
        if modes[i] == SLIPS:
            r[at + 1], r[at + 2] = -mu[i] * force[e] * way[i, 0], -mu[i] * force[e] * way[i, 1]
    return True


@kernel
def sweep(g, c, d, mu, slides, convex, r, sweeps):
    """Non-smooth Gauss-Seidel on `r`, in place: each contact in turn solved exactly for the others as they are.

    Jourdan, Alart and Jean, A Gauss-Seidel like algorithm to solve frictional contact problems (1998).
    """
    m, k = len(mu), g.shape[1]
    x = c + g.T @ r
    w = np.zeros((m, 3, 3))
    for i in range(m):
        for a in range(3):
            for b in range(3):
                for j in range(k):
                    w[i, a, b] += g[3 * i + a, j] * g[3 * i + b, j]
    q, out = np.empty(3), np.empty(3)
    for _ in range(sweeps):
        change, size = 0.0, 0.0
        for i in range(m):
            for a in range(3):
                q[a] = -d[3 * i + a]
                for j in range(k):
                    q[a] += g[3 * i + a, j] * x[j]
            if slides[i]:
                gain = w[i, 0, 0] - mu[i] * w[i, 0, 1]
                if gain <= 0.0:
                    r[:] = np.nan
                    return
                out[0] = max(r[3 * i] - q[0] / gain, 0.0)
                out[1], out[2] = -mu[i] * out[0], 0.0
            else:
                for a in range(3):
                    for b in range(3):
                        q[a] -= w[i, a, b] * r[3 * i + b]
                if convex:
                    out[:] = r[3 * i : 3 * i + 3]
                    _single_convex(w[i], q, mu[i], out)
                else:
                    single(w[i], q, mu[i], out)
            for a in range(3):
                step = out[a] - r[3 * i + a]
                r[3 * i + a] = out[a]
                change, size = max(change, abs(step)), max(size, abs(out[a]))
                for j in range(k):
                    x[j] += g[3 * i + a, j] * step
        if change <= 1e-16 * size:
            return


def newton(
    g: np.ndarray, c: np.ndarray, d: np.ndarray, mu: np.ndarray, slides: np.ndarray, convex: bool, start: np.ndarray
) -> np.ndarray:
    """Newton's method on the projections of Alart and Curnier (1991), from `start`; the best iterate.

    Normal: r_n = max(0, r_n - u_n).  Tangent: r_T = the nearest point to r_T - u_T within µ max(0, r_n - u_n).
    For the convex model: r = P_K(r - u).  Steps are those of least norm, so that redundant contacts do no harm.
    """
    m = len(mu)
    w = g @ g.T
    free = g @ c - d
    r = start.copy()
    best, least = r.copy(), math.inf
    value, jacobian = np.empty(3 * m), np.empty((3 * m, 3 * m))
    for _ in range(ITERATIONS):
        linearise(r, w @ r + free, w, mu, slides, convex, value, jacobian)
        size = float(np.abs(value).max())
        if not math.isfinite(size):
            break
        if size < least:
            best, least = r.copy(), size
        try:
            step = np.linalg.lstsq(jacobian, -value, rcond=1e-13)[0]
        except np.linalg.LinAlgError:
            break
        if float(np.abs(step).max()) <= 1e-16 * float(np.abs(r).max()):
            break
        merit, length = float(value @ value), 1.0
        for _ in range(6):
            trial = r + length * step
            linearise(trial, w @ trial + free, w, mu, slides, convex, value, jacobian)
            if float(value @ value) < merit:
                break
            length *= 0.5
        else:
            trial = r + step
        r = trial
    return best


@kernel
def linearise(r, u, w, mu, slides, convex, value, jacobian):
    """Value and generalised Jacobian of the functions whose zero `newton` seeks."""
    m = len(mu)
    for i in range(m):
        k = 3 * i
        n, a, b = r[k] - u[k], r[k + 1] - u[k + 1], r[k + 2] - u[k + 2]
        # value = r - P(y), y = r - u;  jacobian = 1 - P' (1 - w)
        p = np.zeros((3, 3))
        fixed = np.zeros((3, 3))
        t = math.sqrt(a * a + b * b)
        if slides[i]:
            value[k] = r[k] - max(n, 0.0)
            value[k + 1], value[k + 2] = r[k + 1] + mu[i] * r[k], r[k + 2]
            p[0, 0] = 1.0 if n > 0.0 else 0.0
            fixed[1, 0] = mu[i]
        elif convex:
            x, y, z = project(n, a, b, mu[i])
            value[k], value[k + 1], value[k + 2] = r[k] - x, r[k + 1] - y, r[k + 2] - z
            if t <= mu[i] * n:
                p[0, 0] = p[1, 1] = p[2, 2] = 1.0
            elif mu[i] * t > -n:
                s = 1.0 / (1.0 + mu[i] * mu[i])
                ea, eb = a / t, b / t
                p[0, 0] = s
                p[0, 1] = p[1, 0] = s * mu[i] * ea
                p[0, 2] = p[2, 0] = s * mu[i] * eb
                along, across = s * mu[i] * mu[i], s * mu[i] * (n + mu[i] * t) / t
                p[1, 1] = along * ea * ea + across * eb * eb
                p[2, 2] = along * eb * eb + across * ea * ea
                p[1, 2] = p[2, 1] = (along - across) * ea * eb
        else:
            top = max(n, 0.0)
            value[k] = r[k] - top
            radius = mu[i] * top
            if n > 0.0:
                p[0, 0] = 1.0
            if t <= radius:
                value[k + 1], value[k + 2] = r[k + 1] - a, r[k + 2] - b
                p[1, 1] = p[2, 2] = 1.0
            elif n > 0.0:
                ea, eb = a / t, b / t
                value[k + 1], value[k + 2] = r[k + 1] - radius * ea, r[k + 2] - radius * eb
                p[1, 0], p[2, 0] = mu[i] * ea, mu[i] * eb
                s = radius / t
                p[1, 1], p[2, 2] = s * eb * eb, s * ea * ea
                p[1, 2] = p[2, 1] = -s * ea * eb
            else:
                value[k + 1], value[k + 2] = r[k + 1], r[k + 2]
        for e in range(3):
            for j in range(3 * m):
                total = 0.0
                for f in range(3):
                    total += p[e, f] * w[k + f, j]
                jacobian[k + e, j] = total
            for f in range(3):
                jacobian[k + e, k + f] += fixed[e, f] - p[e, f]
            jacobian[k + e, k + e] += 1.0


def relax(
    g: np.ndarray, c: np.ndarray, d: np.ndarray, mu: np.ndarray, slides: np.ndarray, convex: bool, start: np.ndarray,
    weight: float,
) -> np.ndarray:  # fmt: skip
    """Alternating directions: a linear problem for all contacts at once against projections of each alone.

    ADMM on min ½ |c + Gᵀ r|² over the cones with the term µ |u_T| n taken from the last iterate (Acary and
    Cadoux, 2013; Cadoux' fixed point inside the loop).  Slow, but it does not mind redundant contacts.
    """
    if slides.any():
        return np.full(len(d), np.nan)
    w = g @ g.T
    free = g @ c - d
    rho = weight * float(np.trace(w)) / len(w)
    inverse = np.linalg.inv(w + rho * np.eye(len(w)))
    z, dual = start.copy(), np.zeros(len(d))
    for _ in range(RELAXATIONS):
        u = (w @ z + free).reshape(-1, 3)
        shift = np.zeros((len(mu), 3))
        if not convex:
            shift[:, 0] = mu * np.sqrt(u[:, 1] ** 2 + u[:, 2] ** 2)
        r = inverse @ (rho * (z - dual) - free - shift.ravel())
        new = np.array([project(*y, k) for y, k in zip((r + dual).reshape(-1, 3), mu, strict=True)]).ravel()
        dual += r - new
        done = float(np.abs(new - z).max()) <= 1e-15 * float(np.abs(new).max()) and float(np.abs(r - new).max()) <= (
            1e-14 * float(np.abs(new).max())
        )
        z = new
        if done:
            break
    return z


def pivot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """z >= 0 with a z + b >= 0 and z·(a z + b) = 0 by Lemke's complementary pivoting; a need not be symmetric.

    Cottle, Pang and Stone, The Linear Complementarity Problem (1992), section 4.4.
    """
    m = len(b)
    scale = float(np.abs(b).max()) if m else 0.0
    if (b >= 0.0).all():
        return np.zeros(m)
    table = np.hstack([np.eye(m), -a, -np.ones((m, 1)), (b / scale)[:, None]])
    basis = np.arange(m)
    entering, row = 2 * m, int(np.argmin(b))
    for _ in range(PIVOTS * m + PIVOTS):
        leaving = int(basis[row])
        table[row] /= table[row, entering]
        others = np.arange(m) != row
        table[others] -= np.outer(table[others, entering], table[row])
        basis[row] = entering
        if leaving == 2 * m:
            z = np.zeros(2 * m)
            z[basis[basis < 2 * m]] = table[basis < 2 * m, -1]
            return np.maximum(z[m:], 0.0) * scale
        entering = leaving + m if leaving < m else leaving - m
        candidates = np.flatnonzero(table[:, entering] > 1e-12)
        if len(candidates) == 0:
            break
        ratios = table[candidates, -1] / table[candidates, entering]
        least = candidates[ratios <= ratios.min() + 1e-13]
        ending = least[basis[least] == 2 * m]
        row = int(ending[0] if len(ending) else least[0])
    return np.full(m, np.nan)
