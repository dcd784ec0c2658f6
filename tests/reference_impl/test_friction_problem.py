"""The contact problem with friction: certificates over random problems, closed forms, errors of simpler cones."""

from __future__ import annotations

import numpy as np
import pytest

from reference_impl.contact_problem import NoSolution
from reference_impl.friction_problem import Rough, residual, solve


def random_problem(rng: np.random.Generator, contacts: int, bodies: int, ratio: float = 1.0) -> Rough:
    """Contacts at random places of bodies with random velocities; one body more is fixed."""
    mass = ratio ** rng.uniform(-0.5, 0.5, bodies)
    g = np.zeros((3 * contacts, 6 * bodies))
    for i in range(contacts):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        for sign, body in zip((1.0, -1.0), rng.choice(bodies + 1, 2, replace=False), strict=True):
            if body == bodies:
                continue
            arm = rng.normal(size=3)
            for a in range(3):
                g[3 * i + a, 6 * body : 6 * body + 3] = sign * axes[a] / np.sqrt(mass[body])
                g[3 * i + a, 6 * body + 3 : 6 * body + 6] = sign * np.cross(arm, axes[a]) / np.sqrt(0.4 * mass[body])
    still = np.zeros(contacts, dtype=bool)
    return Rough(g, rng.normal(size=6 * bodies), np.zeros(3 * contacts), rng.uniform(0.0, 1.2, contacts), still)


def block(velocity: tuple[float, float, float], mu: float, corners: int = 4) -> Rough:
    """A block of 1 kg that cannot turn, its velocity or acceleration without contact, on a floor at z = 0."""
    g = np.tile(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), (corners, 1))
    c = np.array(velocity)
    return Rough(g, c, np.zeros(3 * corners), np.full(corners, mu), np.zeros(corners, dtype=bool))


@pytest.mark.parametrize(("contacts", "bodies", "ratio", "count"), [
    (1, 1, 1.0, 300), (2, 2, 1e6, 250), (4, 2, 1.0, 300), (12, 6, 1.0, 120), (12, 6, 1e6, 40), (30, 4, 1.0, 4),
])  # fmt: skip
def test_every_answer_to_a_random_problem_is_certified(contacts, bodies, ratio, count):
    rng = np.random.default_rng(contacts)
    residuals = []
    for _ in range(count):
        p = random_problem(rng, contacts, bodies, ratio)
        answer = solve(p)
        residuals.append(answer.residual)
        scale = np.abs(p.c).max() * np.sqrt((p.g**2).sum(axis=1).max())
        u, r = answer.u, answer.r
        assert u[:, 0].min() >= -1e-10 * scale
        assert np.all(np.hypot(r[:, 1], r[:, 2]) <= p.mu * r[:, 0] + 1e-10 * (1.0 + np.abs(r).max()))
        assert float((r * u).sum()) <= 1e-9 * scale * (1.0 + np.abs(r).max())  # friction never drives
        assert float(answer.x @ answer.x) <= float(p.c @ p.c) * (1.0 + 1e-9)
    assert max(residuals) <= 1e-10
    assert np.mean(np.array(residuals) <= 1e-12) >= 0.99


def test_the_certificate_sees_a_wrong_answer():
    p = block((2.0, 0.0, -1.0), 0.5, 1)
    right = solve(p).r.ravel()
    assert residual(p, right) <= 1e-15
    assert residual(p, right * 1.01) > 1e-3
    assert residual(p, right * np.array([1.0, -1.0, 1.0])) > 1e-3


@pytest.mark.parametrize("heading", [0.0, 0.3, 1.0, 2.5, 4.0])
@pytest.mark.parametrize("corners", [1, 4])
def test_a_block_that_slides_is_braked_by_mu_times_the_normal_impulse(heading, corners):
    way = np.array([np.cos(heading), np.sin(heading), 0.0])
    answer = solve(block(tuple(2.0 * way + [0.0, 0.0, -1.0]), 0.5, corners))
    assert answer.x == pytest.approx(1.5 * way, abs=1e-15)
    assert answer.r[:, 0].sum() == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize(("mu", "moves"), [(0.0, 1.0), (0.499999, 1e-6), (0.5, 0.0), (0.6, 0.0), (1e6, 0.0)])
def test_a_block_holds_up_to_the_edge_of_its_cone(mu, moves):
    answer = solve(block((0.5, 0.0, -1.0), mu))
    assert answer.x[0] == pytest.approx(0.5 * moves if mu == 0.0 else moves, abs=1e-14)
    assert answer.x[2] == pytest.approx(0.0, abs=1e-15)


def test_the_pyramid_is_right_along_its_corners_and_wrong_between():
    def speed(heading: float, sides: int) -> float:
        way = np.array([np.cos(heading), np.sin(heading), 0.0])
        answer = solve(block(tuple(2.0 * way + [0.0, 0.0, -1.0]), 0.5, 1), model="pyramid", sides=sides)
        assert answer.residual <= 1e-12
        return float(np.hypot(answer.x[0], answer.x[1]))

    assert speed(0.0, 4) == pytest.approx(1.5, rel=1e-14)
    assert speed(np.pi / 4.0 + 0.01, 4) > 1.6
    errors = [abs(speed(np.pi / sides * 0.9, sides) - 1.5) for sides in (4, 8, 16, 32)]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-2


def test_the_convex_model_lifts_what_slides():
    answer = solve(block((2.0, 0.0, -1.0), 0.5, 1), model="convex")
    assert answer.residual <= 1e-12
    assert answer.u[0, 0] == pytest.approx(0.5 * np.hypot(*answer.u[0, 1:]), rel=1e-10)
    assert answer.u[0, 0] > 0.4
    at_rest = solve(block((0.4, 0.0, -1.0), 0.5, 1), model="convex")
    assert at_rest.x == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_sliding_without_possible_forces_is_said_so():
    """Painlevé's rod: the normal gains less than nothing from a force that brings its friction along."""
    mass, length, angle, mu = 1.0, 1.0, np.radians(60.0), 1.6
    inertia = mass * length**2 / 12.0
    arm = np.array([0.5 * np.cos(angle), -0.5 * np.sin(angle)])
    n = np.array([0.0, 1.0, arm[0] / np.sqrt(inertia)])
    t = np.array([1.0, 0.0, -arm[1] / np.sqrt(inertia)])
    for way in (1.0, -1.0):
        g = np.array([n, way * t, np.zeros(3)])
        gain = n @ (n - mu * way * t)
        p = Rough(g, np.array([0.0, -9.81, 0.0]), np.zeros(3), np.array([mu]), np.array([True]))
        if gain > 0.0:
            assert solve(p).r[0, 0] == pytest.approx(9.81 / gain, rel=1e-12)
        else:
            with pytest.raises(NoSolution, match="1 contacts"):
                solve(p)


@pytest.mark.parametrize(("choice", "match"), [({"model": "magic"}, "exact, pyramid"), ({"sides": 3}, "sides = 3"),
                                               ({"sides": 5}, "even")])  # fmt: skip
def test_unknown_models_are_named(choice, match):
    with pytest.raises(ValueError, match=match):
        solve(block((1.0, 0.0, -1.0), 0.5), **choice)


def test_where_one_of_redundant_contacts_begins_to_slide_the_split_does_not_depend_on_the_guess():
    ways, rows = np.array(((1.0, 0.2), (1.0, 0.0), (0.5, 0.9), (0.1, 1.0))), []
    for (x, y), way in zip(((-1, -1), (-1, 1), (1, -1), (1, 1)), ways, strict=True):
        along = np.array((*way, 0.0)) / np.hypot(*way)
        tangents = along, np.array((-along[1], along[0], 0.0))
        rows += [np.concatenate([t, np.cross((x, y, -1.0), t)]) for t in ((0.0, 0.0, 1.0), *tangents)]
    free, slides = np.array((6.0, 2.0, -9.81, 0.1, 0.2, 1.0)), np.array((True, False, True, True))
    problem = Rough(np.array(rows), free, np.zeros(12), np.full(4, 0.3), slides)
    one, other = solve(problem), solve(problem, guess=np.full(4, 2))
    assert max(one.residual, other.residual) <= 1e-12
    np.testing.assert_allclose(one.x, other.x, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(one.r[:, 0], other.r[:, 0], rtol=0.0, atol=1e-9)
