"""When a tumbling box meets the floor: how exactly, whether the first contact is ever passed, and how long it takes."""

from __future__ import annotations

import time
from functools import partial

import mpmath
import numpy as np
from mpmath import mpf

from benchmarks.engines import played
from benchmarks.row import Figure, Row
from benchmarks.truths import DIGITS, agreed, tumble, tumble_closed
from mechanics.effects import Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from reference_impl.advancement import HIT, approach_plane
from reference_impl.collide.primitives import corner
from reference_impl.flight import continued_flight, free_flight
from reference_impl.kernels import apply, cross, kernel, matrix
from reference_impl.state import ORDER, bodies_of, motion_of

SIZE, SPIN, CLEARANCE, G = (0.4, 0.6, 1.0), (5.0, 2.0, 3.0), 2.0, 9.81  # moments fall from axis 1 to axis 3
FAST, SLOW = 60.0, 4.0  # scale of the spins [rad/s]
GRID = 2e-4  # [s], of the independent motion; cubic between its points
VISIBLE = 1e-7  # depth that counts as passed [m]: a hundred times what the independent motion errs
STEP = 1.0 / 60.0  # [s], at whose ends a stepping engine looks


def scene(size: tuple, spin: tuple, height: float, q: tuple = (1.0, 0.0, 0.0, 0.0)) -> Scene:
    """A box over a floor, which stops dead."""
    box = Body("box", Box(size), 1.0, (0.0, 0.0, height), q, angular_velocity=spin)
    return Scene((Body("floor", HalfSpace()), box), (Gravity((0.0, 0.0, -G)), Rotation(), Restitution(0.0), Resting()))


def true_time(near: float) -> mpf:
    """When the lowest corner of the box is on the floor, by Newton's method from a time near it [s]."""
    size = [mpf(c) for c in SIZE]
    moments = [float((size[k - 1] ** 2 + size[k - 2] ** 2) / 12) for k in range(3)]
    order = [2, 1, 0]  # the closed form wants the moments to rise; an odd permutation turns the other way round

    def attitude(t: mpf) -> list[mpf]:
        sorted_moments, sorted_spin = [moments[k] for k in order], [-SPIN[k] for k in order]
        w, x, y, z = tumble_closed(sorted_moments, (1.0, 0.0, 0.0, 0.0), sorted_spin, t)
        return agreed([w, -z, -y, -x], tumble(moments, (1.0, 0.0, 0.0, 0.0), SPIN, t))

    def gap(t: mpf) -> mpf:
        w, x, y, z = attitude(t)
        last = (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))  # third row of the rotation
        return mpf(HEIGHT) - mpf(G) * t * t / 2 - sum(abs(a) * s / 2 for a, s in zip(last, size, strict=True))

    with mpmath.workdps(DIGITS):
        return mpmath.findroot(gap, (mpf(near) - mpf("1e-9"), mpf(near) + mpf("1e-9")), tol=mpf("1e-70"))


HEIGHT = CLEARANCE + 1.0  # of the centre [m]


def random_boxes(count: int, scale: float) -> tuple[np.ndarray, ...]:
    """Half edges (count, 3) [m], heights (count,) [m], attitudes (count, 4) and body spins (count, 3) [rad/s]."""
    rng = np.random.default_rng(2027)
    half = 0.5 * rng.uniform(0.2, 1.0, (count, 3))
    q = rng.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    axis = rng.normal(size=(count, 3))
    return half, rng.uniform(2.0, 3.0, count), q, scale * axis / np.linalg.norm(axis, axis=1, keepdims=True)


def measure(tiny: bool = False) -> Row:
    """One box against forty digits, and thousands of boxes against an independent motion."""
    count = 20 if tiny else 5000
    whole = played(scene(SIZE, SPIN, HEIGHT), [0.0, 1.0])
    found = whole.events[0].time
    boxes = random_boxes(count, FAST)
    times, evaluations, _ = contacts(boxes)
    late, low, stepped = _passed(boxes, times)
    _, _, seconds = contacts(random_boxes(count, SLOW), repeats=1 if tiny else 5)
    return Row(
        name="contact-time",
        subject="a tumbling box meets the floor",
        figures=(
            Figure("time of contact, error", float(abs(mpf(found) - true_time(found))), 1e-14, "s"),
            Figure(f"first contacts passed, of {count} boxes at {FAST:g} rad/s", float(late), 0.0),
            Figure("path and search in the kernel, per box", seconds / count, 10e-6, "s"),
        ),
        how=f"truth of one box with {DIGITS} digits by two routes; {count} boxes against an independent motion in "
        f"steps of {GRID:g} s, cubic between: passed is what is below the floor by {VISIBLE:g} m before its contact, "
        f"where the lowest corner is {low:.1g} m from the floor at most; a search at the ends of steps of 1/60 s "
        f"passes {stepped} of them; "
        f"{int(np.median(evaluations))} evaluations in the median, {int(evaluations.max())} at most",
    )


def contacts(boxes: tuple[np.ndarray, ...], repeats: int = 1) -> tuple[np.ndarray, np.ndarray, float]:
    """Times of the first contacts [s], evaluations of the gap, and the least wall time of all of them together [s]."""
    half, height, q, spins = boxes
    flights = []
    for k in range(len(half)):
        one = scene(tuple(2.0 * half[k]), (0.0, 0.0, 0.0), float(height[k]), tuple(q[k]))
        b = bodies_of(one)
        momentum = matrix(q[k]) @ (b.inertia[1] @ spins[k])
        flights.append((motion_of(one, b).x[1], momentum, b.moments[1], b.frame[1], b.quickness[1], b.unevenness[1]))
    x, momentum, moments, frame, quickness, unevenness = (np.array(part) for part in zip(*flights, strict=True))
    times, evaluations = np.empty(len(x)), np.empty(len(x), dtype=np.int64)
    search = partial(_search, x, q, momentum, moments, frame, quickness, unevenness, half, times, evaluations)
    search()  # compiled, or loaded, before it is clocked
    walls = []
    for _ in range(repeats):
        begun = time.perf_counter()
        search()
        walls.append(time.perf_counter() - begun)
    return times, evaluations, min(walls)


@kernel
def _search(x, q, momentum, moments, frame, quickness, unevenness, half, times, evaluations):
    """First contact of each box with the floor: its path as polynomials, one by one, and the search on them."""
    pull = np.array([0.0, 0.0, -G])
    normal = np.array([0.0, 0.0, 1.0])
    xs, qs, spins = np.zeros((ORDER + 1, 3)), np.zeros((ORDER + 1, 4)), np.zeros((ORDER + 1, 3))
    kept, bounds, speed = np.zeros(4), np.zeros(6), np.zeros(3)
    rest, still, nowhere = np.zeros((ORDER + 1, 3)), np.zeros(6), np.zeros(3)
    corners = np.empty((8, 3))
    for k in range(len(x)):
        for j in range(8):
            corner(half[k], j, corners[j])
        t, place, turn = 0.0, x[k].copy(), q[k].copy()
        evaluations[k] = 0
        span = free_flight(
            place, nowhere, turn, momentum[k], pull, 0.0, moments[k], frame[k], quickness[k], unevenness[k], True,
            xs, qs, spins, kept, bounds,
        )  # fmt: skip
        while True:
            found, state, count = approach_plane(
                t, t + span, t, xs, qs, corners, 0.0, bounds, 0.0, rest, normal, still, 1e-12, 1e-12, False, 1e-9, 1e-9
            )
            evaluations[k] += count
            if state == HIT:
                break
            span = continued_flight(
                found - t, place, speed, turn, momentum[k], pull, 0.0, moments[k], frame[k], xs, qs, spins, kept, bounds
            )
            t = found
        times[k] = found


def _passed(boxes: tuple[np.ndarray, ...], times: np.ndarray) -> tuple[int, float, int]:
    """First contacts that were passed, the greatest distance from the floor at one [m], and those that steps pass."""
    half, height, q, spins = boxes
    moments = np.stack([half[:, k - 1] ** 2 + half[:, k - 2] ** 2 for k in range(3)], axis=1) / 3.0
    depth, ends, first = np.empty(len(half)), np.empty(len(half)), np.empty(len(half))
    _watch(half, height, q, moments, spins, times, GRID, STEP, depth, ends, first)
    stepped = int((first > np.ceil(times / STEP) * STEP + 0.5 * STEP).sum())
    return int((depth < -VISIBLE).sum()), float(np.abs(ends).max()), stepped


@kernel
def _watch(half, height, attitude, moments, spins, times, grid, step, depth, ends, first):
    """Deepest corner before the contact and at it [m], and the first step's end with a corner below the floor [s].

    Runge-Kutta 4 on q' = ½ q w and Euler's equations in the body; between its points each corner goes by the cubic
    through its heights and rates.
    """
    for k in range(len(half)):
        q, w = attitude[k].copy(), spins[k].copy()
        old, fall = np.empty(8), np.empty(8)
        new, rise = np.empty(8), np.empty(8)
        depth[k], first[k] = np.inf, np.inf
        whole = int(np.floor(times[k] / grid))
        _heights(half[k], height[k], 0.0, q, w, old, fall)
        for n in range(whole + 1):
            t = n * grid
            h = min(grid, times[k] - t)
            _turn(q, w, moments[k], h)
            _heights(half[k], height[k], t + h, q, w, new, rise)
            for c in range(8):
                if n < whole:
                    depth[k] = min(depth[k], _lowest(h, old[c], fall[c], new[c], rise[c]))
                old[c], fall[c] = new[c], rise[c]
        ends[k] = new.min()
        q, w, t = attitude[k].copy(), spins[k].copy(), 0.0
        parts = int(np.ceil(step / grid))
        while first[k] == np.inf:
            for _ in range(parts):
                _turn(q, w, moments[k], step / parts)
            t += step
            _heights(half[k], height[k], t, q, w, new, rise)
            if new.min() < 0.0:
                first[k] = t


@kernel
def _heights(half, height, t, q, w, low, rate):
    """Heights of the eight corners [m] and their rates [m/s] of a box that has been falling for t."""
    r = matrix(q)
    turning = apply(r, w)
    for c in range(8):
        corner = np.empty(3)
        for a in range(3):
            corner[a] = half[a] if (c >> a) & 1 else -half[a]
        arm = apply(r, corner)
        low[c] = height - 0.5 * G * t * t + arm[2]
        rate[c] = -G * t + cross(turning, arm)[2]


@kernel
def _lowest(h, a, da, b, db):
    """Least value within h of the cubic with values a, b and rates da, db at its ends."""
    least = min(a, b)
    if da < 0.0 < db:
        # rate da + 2 s₂ x + 3 s₃ x² of x = t/h
        second = 3.0 * (b - a) - h * (2.0 * da + db)
        third = h * (da + db) - 2.0 * (b - a)
        root = np.sqrt(max(second * second - 3.0 * third * h * da, 0.0))
        x = -h * da / (second + root)
        least = min(least, a + x * (h * da + x * (second + x * third)))
    return least


@kernel
def _turn(q, w, moments, h):
    """One Runge-Kutta step of order four for attitude q and body angular velocity w, in place."""
    k = np.empty((4, 7))
    for stage in range(4):
        p, u = q.copy(), w.copy()
        if stage > 0:
            reach = h if stage == 3 else 0.5 * h
            for c in range(4):
                p[c] += reach * k[stage - 1, c]
            for c in range(3):
                u[c] += reach * k[stage - 1, 4 + c]
        k[stage, 0] = -0.5 * (p[1] * u[0] + p[2] * u[1] + p[3] * u[2])
        k[stage, 1] = 0.5 * (p[0] * u[0] + p[2] * u[2] - p[3] * u[1])
        k[stage, 2] = 0.5 * (p[0] * u[1] - p[1] * u[2] + p[3] * u[0])
        k[stage, 3] = 0.5 * (p[0] * u[2] + p[1] * u[1] - p[2] * u[0])
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            k[stage, 4 + c] = (moments[d] - moments[e]) * u[d] * u[e] / moments[c]
    size = 0.0
    for c in range(4):
        q[c] += h / 6.0 * (k[0, c] + 2.0 * k[1, c] + 2.0 * k[2, c] + k[3, c])
        size += q[c] * q[c]
    for c in range(4):
        q[c] /= np.sqrt(size)
    for c in range(3):
        w[c] += h / 6.0 * (k[0, 4 + c] + 2.0 * k[1, 4 + c] + 2.0 * k[2, 4 + c] + k[3, 4 + c])
