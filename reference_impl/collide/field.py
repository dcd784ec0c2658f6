"""Distance fields: the signed distance of a shape, sampled once on a regular grid and interpolated.

The gap of a point is negative inside.  Two interpolations:

    linear   trilinear between the nodes: O(h²), gradient O(h) with jumps from cell to cell
    cubic    cubic B-spline through the nodes: O(h⁴), gradient O(h³) and smooth, about five times the cost

both where the distance is smooth.  It is not at ridges, where two features are equally near (inside every
edge of a box, at the centre of a sphere): there any interpolation is O(h) and its gradient wrong by up
to the angle between the faces.  For spheres, boxes and half-spaces use their closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechanics.shapes import Box, Mesh, Shape, Sphere
from reference_impl.collide.mesh_distance import mesh_distance
from reference_impl.errors import Unsupported
from reference_impl.kernels import kernel

LINEAR, CUBIC = "linear", "cubic"
FEWEST = 4  # cells along an edge: the end conditions of the spline need five nodes
MARGIN = 0.15  # of the shape's greatest extent, on each side

Distance = Callable[[np.ndarray], np.ndarray]  # points (m, 3) -> signed distances (m,) [m]


class OutsideField(ValueError):
    """A query at `point` outside the grid from `low` to `high` [m], or with a NaN in it."""

    def __init__(self, point: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
        self.point, self.low, self.high = point, low, high
        at, least, most = (" ".join(f"{value:.6g}" for value in v) for v in (point, low, high))
        super().__init__(f"point ({at}) lies outside the distance field from ({least}) to ({most}) m")


@dataclass(frozen=True)
class Deviation:
    """How far a field is from the exact distance, over points near the surface."""

    gap: float  # greatest [m]
    mean: float  # root mean square [m]
    normal: float  # greatest angle between the gradient and the exact one [rad]


@dataclass(frozen=True)
class Field:
    """Signed distance on a regular grid.  `field_of` and `sampled` make it.

    Attributes
    ----------
    low, high : (3,) arrays
        Corners of the grid [m].
    spacing : float
        Edge of its cubic cells [m].
    method : str
        "linear" or "cubic".
    values : (nx, ny, nz) array
        Distances at the nodes [m], or the spline's coefficients, which need one more on each side.
    """

    low: np.ndarray
    high: np.ndarray
    spacing: float
    method: str
    values: np.ndarray

    def gap(self, points: np.ndarray) -> np.ndarray:
        """Signed distances [m] at `points` (m, 3), or at one point (3,).

        Raises
        ------
        OutsideField
            For the first point outside the grid, or with a NaN in it.
        """
        return self.gap_and_gradient(points)[0]

    def gap_and_gradient(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distances [m] and their gradients, which are the interpolant's own and of length one only nearly.

        Raises
        ------
        OutsideField
            As in `gap`.
        """
        at = np.ascontiguousarray(np.atleast_2d(points), dtype=np.float64)
        gap, gradient = np.empty(len(at)), np.empty((len(at), 3))
        bad = _query(self.values, self.low, self.high, self.spacing, self.method == CUBIC, at, gap, gradient)
        if bad >= 0:
            raise OutsideField(at[bad], self.low, self.high)
        return (gap, gradient) if np.ndim(points) == 2 else (gap[0], gradient[0])

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Which of `points` (m, 3) lie within the grid."""
        return np.all((points >= self.low) & (points <= self.high), axis=1)

    def deviation(self, distance: Distance, band: float, count: int = 20_000, seed: int = 0) -> Deviation:
        """Error against an exact distance at `count` random points no further than `band` [m] from the surface."""
        rng = np.random.default_rng(seed)
        points = rng.uniform(self.low, self.high, (count, 3))
        exact = distance(points)
        near = np.abs(exact) <= band
        points, exact = points[near], exact[near]
        gap, gradient = self.gap_and_gradient(points)
        h = 1e-6 * float((self.high - self.low).max())
        steps = h * np.eye(3)
        slope = np.stack([distance(points + step) - distance(points - step) for step in steps], axis=1)
        across = np.linalg.norm(np.cross(gradient, slope), axis=1)
        angle = np.arctan2(across, np.einsum("ij,ij->i", gradient, slope))
        error = gap - exact
        return Deviation(float(np.abs(error).max()), float(np.sqrt(np.mean(error**2))), float(angle.max()))


def field_of(shape: Shape, cells: int = 64, method: str = CUBIC, margin: float = MARGIN) -> Field:
    """Field of a sphere, box or closed mesh, body frame.

    Parameters
    ----------
    cells : int
        Along the shape's greatest extent, margins included.
    method : str
        "cubic" or "linear".
    margin : float
        Width of the grid beyond the shape, over its greatest extent.

    Raises
    ------
    Unsupported
        For another shape.
    ValueError
        As in `sampled`.
    """
    distance = distance_of(shape)
    low, high = _extent(shape)
    edge = margin * float((high - low).max())
    return sampled(distance, low - edge, high + edge, cells, method)


def distance_of(shape: Shape) -> Distance:
    """Function of points (m, 3) in the body frame that returns their exact signed distances (m,) [m].

    Raises
    ------
    Unsupported
        For a shape without one here.
    """
    match shape:
        case Sphere(radius):
            return lambda points: np.linalg.norm(points, axis=1) - radius
        case Box(size):
            return lambda points: box_distance(points, 0.5 * np.array(size))
        case Mesh():
            return mesh_distance(shape)
    raise Unsupported(f"distance field of a {type(shape).__name__}: only Sphere, Box and Mesh")


def box_distance(points: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Signed distance (m,) of `points` (m, 3) from a box with half edges `half` [m]."""
    excess = np.abs(points) - half
    return np.linalg.norm(np.maximum(excess, 0.0), axis=1) + np.minimum(excess.max(axis=1), 0.0)


def sampled(distance: Distance, low: np.ndarray, high: np.ndarray, cells: int = 64, method: str = CUBIC) -> Field:
    """Field of any signed distance between the corners `low` and `high` [m].

    The cells are cubes, `cells` of them along the longest edge; `high` moves out to whole cells.

    Raises
    ------
    ValueError
        For an unknown method, corners out of order, fewer than `FEWEST` cells, or a distance that is not finite.
    """
    low, high = np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)
    if method not in (LINEAR, CUBIC):
        raise ValueError(f"method = {method!r}; allowed: {LINEAR}, {CUBIC}")
    if not (np.isfinite(low).all() and np.isfinite(high).all() and (low < high).all()):
        raise ValueError(f"low = {low}, high = {high}; allowed: finite corners, low < high")
    if cells < FEWEST:
        raise ValueError(f"cells = {cells!r}; allowed: at least {FEWEST}")
    spacing = float((high - low).max()) / cells
    counts = np.maximum(np.ceil((high - low) / spacing - 1e-9).astype(int), FEWEST) + 1
    axes = [low[c] + spacing * np.arange(counts[c]) for c in range(3)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    values = np.asarray(distance(nodes), dtype=np.float64).reshape(tuple(counts))
    if not np.isfinite(values).all():
        raise ValueError("the distance is not finite everywhere on the grid")
    if method == CUBIC:
        values = _prefiltered(values)
    return Field(low, np.array([axis[-1] for axis in axes]), spacing, method, np.ascontiguousarray(values))


def _extent(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    match shape:
        case Sphere(radius):
            return np.full(3, -radius), np.full(3, radius)
        case Box(size):
            return -0.5 * np.array(size), 0.5 * np.array(size)
    points = np.array(shape.vertices)
    return points.min(axis=0), points.max(axis=0)


def _prefiltered(values: np.ndarray) -> np.ndarray:
    """Coefficients of the cubic B-spline through `values`, one more on each side along every axis.

    Along an axis (c₋₁ + 4 c₀ + c₁) / 6 is the value at a node; the two conditions that are missing make
    the third derivative continuous at the last node but one (not-a-knot), which keeps O(h⁴) up to the border.
    de Boor, A Practical Guide to Splines (1978), chapter IV.
    """
    from scipy.linalg import solve_banded

    for axis in range(3):
        rows = np.moveaxis(values, axis, 0)
        n = len(rows)
        band = np.zeros((9, n + 2))  # band[4 + i - j, j] is the matrix element (i, j)
        for j, weight in enumerate((1.0, -4.0, 6.0, -4.0, 1.0)):
            band[4 - j, j] = weight
            band[8 - j, n - 3 + j] = weight
        inner = np.arange(1, n + 1)
        for offset, weight in ((-1, 1.0), (0, 4.0), (1, 1.0)):
            band[4 - offset, inner + offset] = weight / 6.0
        given = np.zeros((n + 2, rows[0].size))
        given[1:-1] = rows.reshape(n, -1)
        solved = solve_banded((4, 4), band, given)
        values = np.moveaxis(solved.reshape(n + 2, *rows.shape[1:]), 0, axis)
    return values


@kernel
def _query(values, low, high, spacing, cubic, points, gap, gradient):
    """Distances and gradients at all points; number of the first that lies outside, or -1."""
    for k in range(len(points)):
        inside = True
        for c in range(3):
            inside = inside and low[c] <= points[k, c] <= high[c]  # False for NaN
        if not inside:
            return k
        if cubic:
            gap[k] = cubic_at(values, low, spacing, points[k], gradient[k])
        else:
            gap[k] = linear_at(values, low, spacing, points[k], gradient[k])
    return -1


@kernel
def _cell(x, low, spacing, cells):
    """Number of the cell that holds x, and the place in it from 0 to 1."""
    s = (x - low) / spacing
    i = min(max(math.floor(s), 0), cells - 1)
    return i, s - i


@kernel
def linear_at(values, low, spacing, point, gradient):
    """Trilinear distance at a point inside the grid [m]; writes the gradient."""
    i, s = _cell(point[0], low[0], spacing, values.shape[0] - 1)
    j, t = _cell(point[1], low[1], spacing, values.shape[1] - 1)
    k, u = _cell(point[2], low[2], spacing, values.shape[2] - 1)
    gap = 0.0
    gradient[0] = gradient[1] = gradient[2] = 0.0
    for a in range(2):
        wa = s if a else 1.0 - s
        da = 1.0 if a else -1.0
        for b in range(2):
            wb = t if b else 1.0 - t
            db = 1.0 if b else -1.0
            for c in range(2):
                wc = u if c else 1.0 - u
                dc = 1.0 if c else -1.0
                value = values[i + a, j + b, k + c]
                gap += wa * wb * wc * value
                gradient[0] += da * wb * wc * value / spacing
                gradient[1] += wa * db * wc * value / spacing
                gradient[2] += wa * wb * dc * value / spacing
    return gap


@kernel
def _weights(s, w, d):
    """The four cubic B-splines that are not zero at s in [0, 1], and their derivatives."""
    r = 1.0 - s
    w[0] = r * r * r / 6.0
    w[1] = (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0
    w[2] = (4.0 - 6.0 * r * r + 3.0 * r * r * r) / 6.0
    w[3] = s * s * s / 6.0
    d[0] = -0.5 * r * r
    d[1] = -2.0 * s + 1.5 * s * s
    d[2] = 2.0 * r - 1.5 * r * r
    d[3] = 0.5 * s * s


@kernel
def cubic_at(values, low, spacing, point, gradient):
    """Spline distance at a point inside the grid [m]; writes the gradient."""
    w, d = np.empty((3, 4)), np.empty((3, 4))
    i, s = _cell(point[0], low[0], spacing, values.shape[0] - 3)
    j, t = _cell(point[1], low[1], spacing, values.shape[1] - 3)
    k, u = _cell(point[2], low[2], spacing, values.shape[2] - 3)
    _weights(s, w[0], d[0])
    _weights(t, w[1], d[1])
    _weights(u, w[2], d[2])
    gap = gx = gy = gz = 0.0
    for a in range(4):
        for b in range(4):
            line = slope = 0.0
            for c in range(4):
                value = values[i + a, j + b, k + c]
                line += w[2, c] * value
                slope += d[2, c] * value
            gap += w[0, a] * w[1, b] * line
            gx += d[0, a] * w[1, b] * line
            gy += w[0, a] * d[1, b] * line
            gz += w[0, a] * w[1, b] * slope
    gradient[0], gradient[1], gradient[2] = gx / spacing, gy / spacing, gz / spacing
    return gap
