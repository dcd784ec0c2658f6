"""Degenerate problems of friction, as the solvers get them: where Painlevé begins, and where solvers could differ."""

from __future__ import annotations

import numpy as np
import pytest

from reference_impl.contact_problem import NoSolution
from reference_impl.friction_newton import newton
from reference_impl.friction_problem import Rough, residual, solve
from reference_impl.friction_solvers import relax, sweep


def sliding(gain, free):
    """One contact that slides: its gap accelerates by gain f + free under the force f, friction included."""
    mu, g = 1.0, np.array([[1.0, 0.0, 0.0], [1.0 - gain, 0.0, 1.0], [0.0, 1.0, 0.0]])
    return Rough(g, np.array([free, 0.0, 0.0]), np.zeros(3), np.array([mu]), np.array([True]))


@pytest.mark.parametrize("gain", [1.0, 1e-6, 0.0, -1e-6, -0.5])
@pytest.mark.parametrize("free", [-9.81, 0.0, 2.0])
def test_a_contact_that_slides_where_painleve_begins(gain, free):
    """0 <= f, p f + b >= 0: one solution for p > 0, none for p <= 0 > b, f = 0 (of two, if p < 0) for b >= 0."""
    problem = sliding(gain, free)
    if free < 0.0 and gain <= 0.0:
        with pytest.raises(NoSolution, match="1 contacts"):
            solve(problem)
        return
    answer = solve(problem)
    f, normal = answer.r[0, 0], answer.u[0, 0]
    assert answer.r[0, 1] == -f
    if gain > 0.0:
        assert f == pytest.approx(max(-free, 0.0) / gain, rel=1e-9)
    assert min(f, normal) == pytest.approx(0.0, abs=1e-9)


def planar_problem(rng, contacts, bodies):
    """Contacts in the x-z plane of bodies that can also move, but do not, along y: there the cone is a pyramid."""
    mass = rng.uniform(0.5, 2.0, bodies)
    g = np.zeros((3 * contacts, 4 * bodies))
    for i in range(contacts):
        angle = rng.uniform(0.0, 2.0 * np.pi)
        n, t = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        for sign, b in zip((1.0, -1.0), rng.choice(bodies + 1, 2, replace=False), strict=True):
            if b < bodies:
                arm, at = rng.normal(size=2), slice(4 * b, 4 * b + 2)
                for row, axis in ((3 * i, n), (3 * i + 1, t)):
                    g[row, at] = sign * axis / np.sqrt(mass[b])
                    g[row, 4 * b + 2] = sign * (arm[0] * axis[1] - arm[1] * axis[0]) / np.sqrt(0.4 * mass[b])
                g[3 * i + 2, 4 * b + 3] = sign / np.sqrt(mass[b])
    c = rng.normal(size=4 * bodies)
    c[3::4] = 0.0
    still = np.zeros(contacts, dtype=bool)
    return Rough(g, c, np.zeros(3 * contacts), rng.uniform(0.0, 0.5, contacts), still)


def unit(p):
    """The problem with normal rows of unit length, as the solvers take it."""
    scale = np.repeat(np.linalg.norm(p.g[::3], axis=1), 3)
    return p._replace(g=np.ascontiguousarray(p.g / scale[:, None]))


def test_every_solver_of_friction_finds_the_same_motion():
    """Gauss-Seidel, Newton from its start, alternating directions and pivots, on 100 planar problems.

    Coulomb's law may have several solutions; below µ = 1/2 certified answers hardly ever differ.
    """
    rng = np.random.default_rng(7)
    differ, certified = 0, dict.fromkeys(("sweeps", "newton", "relaxation", "pivots"), 0)
    for _ in range(100):
        p = unit(planar_problem(rng, int(rng.integers(1, 6)), int(rng.integers(1, 5))))
        swept = np.zeros(len(p.d))
        sweep(p.g, p.c, p.d, p.mu, p.slides, False, swept, 3000)
        few = np.zeros(len(p.d))
        sweep(p.g, p.c, p.d, p.mu, p.slides, False, few, 30)
        said = {
            "sweeps": swept,
            "newton": newton(p.g, p.c, p.d, p.mu, p.slides, False, few),
            "relaxation": relax(p.g, p.c, p.d, p.mu, p.slides, False, few, 1.0),
            "pivots": solve(p, model="pyramid").r.ravel(),
        }
        good = {name: r for name, r in said.items() if np.isfinite(r).all() and residual(p, r) <= 1e-10}
        for name in good:
            certified[name] += 1
        motions = [p.c + p.g.T @ r for r in (*good.values(), solve(p).r.ravel())]
        differ += max(np.abs(x - motions[-1]).max() for x in motions) > 1e-8
    assert differ <= 1
    assert min(certified.values()) >= 98
