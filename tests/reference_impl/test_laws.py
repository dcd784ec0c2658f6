"""Every impact law by name against its own exact prediction, and what the laws have in common."""

from __future__ import annotations

from fractions import Fraction as F
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.effects import Friction, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from reference_impl.effects.impact import LAWS, Collision
from reference_impl.errors import Unsupported
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin

ONE_BY_ONE = ("propagation", "sequential")
AT_ONCE = ("simultaneous", "poisson")


def collision(rows, masses, velocities, e) -> tuple[Collision, np.ndarray]:
    """Contacts with Jacobian `rows` of point masses; e a number or one per contact."""
    root = np.sqrt(np.array(masses, dtype=float))
    g = np.array(rows, dtype=float) / root
    every = np.broadcast_to(np.array(e, dtype=float), (len(g),))
    return Collision(g, root * np.array(velocities, dtype=float), np.zeros(len(g)), lambda u: every, 1e-12), root


def after(law, rows, masses, velocities, e) -> np.ndarray:
    c, root = collision(rows, masses, velocities, e)
    return (c.motion + c.rows.T @ LAWS[law](c).impulses) / root


def line(n: int) -> np.ndarray:
    """Contacts between neighbours in a row of n."""
    return np.eye(n)[1:] - np.eye(n)[:-1]


def common(masses, velocities) -> float:
    """Velocity of the centre of mass, of all bodies after a plastic impact in a closed row."""
    return float(np.dot(masses, velocities) / np.sum(masses))


class Row(NamedTuple):
    """Touching balls in a row and their exact velocities after the elastic impact."""

    before: tuple
    masses: tuple
    propagated: tuple
    together: tuple


ROWS = {
    "cradle 1 of 2": Row((1, 0), (1, 1), (0, 1), (0, 1)),
    "cradle 1 of 3": Row((1, 0, 0), (1,) * 3, (0, 0, 1), (F(-1, 3), F(2, 3), F(2, 3))),
    "cradle 1 of 5": Row((1, 0, 0, 0, 0), (1,) * 5, (0, 0, 0, 0, 1), (F(-3, 5), *(F(2, 5),) * 4)),
    "cradle 2 of 5": Row((1, 1, 0, 0, 0), (1,) * 5, (0, 0, 0, 1, 1), (*(F(-1, 5),) * 2, *(F(4, 5),) * 3)),
    "cradle 3 of 5": Row((1, 1, 1, 0, 0), (1,) * 5, (0, 0, 1, 1, 1), (*(F(1, 5),) * 3, *(F(6, 5),) * 2)),
    "cradle 1 of 7": Row((1, *(0,) * 6), (1,) * 7, (*(0,) * 6, 1), (F(-5, 7), *(F(2, 7),) * 6)),
    "3:1:1:1": Row((1, 0, 0, 0), (3, 1, 1, 1), (F(1, 8), F(3, 8), F(3, 4), F(3, 2)), (0, 1, 1, 1)),
    "1:3:1": Row((1, 0, 0), (1, 3, 1), (F(-1, 2), F(1, 4), F(3, 4)), (F(-3, 5), F(2, 5), F(2, 5))),
}


@pytest.mark.parametrize("law", list(LAWS))
@pytest.mark.parametrize("name", list(ROWS))
def test_an_elastic_row_of_balls(name, law):
    row = ROWS[name]
    expected = row.together if law in AT_ONCE else row.propagated
    found = after(law, line(len(row.masses)), row.masses, row.before, 1.0)
    assert found == pytest.approx([float(v) for v in expected], abs=1e-14)


@pytest.mark.parametrize("e", [0.0, 0.3, 0.8])
@pytest.mark.parametrize("name", list(ROWS))
def test_rows_of_balls_that_bounce_less(name, e):
    """At once: y⁺ = ȳ + e (ȳ - y⁻) with the common velocity ȳ of what moves together; blend: e y_elastic + (1 - e) ȳ.

    Both hold where the plastic impact leaves the whole row together, as in all of these.
    """
    row = ROWS[name]
    rows, mean = line(len(row.masses)), common(row.masses, row.before)
    for law in AT_ONCE:
        elastic = np.array([float(v) for v in row.together])
        expected = mean + e * (elastic - mean)
        assert after(law, rows, row.masses, row.before, e) == pytest.approx(expected, abs=1e-14), law
    blend = e * np.array([float(v) for v in row.propagated]) + (1.0 - e) * mean
    assert after("reflections", rows, row.masses, row.before, e) == pytest.approx(blend, abs=1e-14)


@pytest.mark.parametrize(("e", "last"), [(0.8, 0.6561), (0.9, 0.81450625), (1.0, 1.0)])
def test_the_last_ball_of_a_damped_cradle(e, last):
    """((1 + e)/2)⁴ where impacts travel along the row; the blend gives e + (1 - e)/5."""
    for law in ONE_BY_ONE:
        assert after(law, line(5), (1,) * 5, (1, 0, 0, 0, 0), e)[-1] == pytest.approx(last, rel=1e-14)
    assert after("reflections", line(5), (1,) * 5, (1, 0, 0, 0, 0), e)[-1] == pytest.approx(e + (1.0 - e) / 5.0)


@pytest.mark.parametrize("law", [law for law in LAWS if law != "sequential"])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_symmetric_impacts_stay_symmetric(law, e):
    """A ball between two others, and a box that lands flat: one contact at a time is the only law that takes sides."""
    root = np.sqrt(0.75)
    n1, n2 = np.array((root, 0.5)), np.array((root, -0.5))
    rows = np.zeros((2, 6))
    rows[0, :2], rows[0, 2:4], rows[1, :2], rows[1, 4:] = -n1, n1, -n2, n2
    p = (1.0 + e) * root / 2.5
    expected = (1.0 - 2.0 * p * root, 0.0, *(p * n1), *(p * n2))
    assert after(law, rows, (1,) * 6, (1, 0, 0, 0, 0, 0), e) == pytest.approx(expected, abs=1e-15)
    landed = after(law, [[1.0, -0.5], [1.0, 0.5]], (1.0, 1.25 / 12.0), (-2.0, 0.0), e)
    assert landed == pytest.approx((2.0 * e, 0.0), abs=1e-14)


def test_newton_and_poisson_part_where_contacts_bounce_differently():
    """A ball squeezed between one with e = 1 and one with e = 0: compression is the same, what comes back is not.

    Equal masses at 1, 0, 0: compression gives 1/3 each with impulses 2/3 and 1/3.  Newton: u⁺ = (1, 0), hence
    (-1/3, 2/3, 2/3).  Poisson returns 2/3 at the first contact alone: (-1/3, 1, 1/3) approach again and are stopped
    together: (-1/3, 2/3, 2/3).  With e = 0 and 1 Newton asks for (0, 0): (1/3, 1/3, 1/3); Poisson: (1/3, 0, 2/3), where
    the first two approach once more and stop at 1/6.
    """
    newton, poisson = (after(law, line(3), (1,) * 3, (1, 0, 0), (1.0, 0.0)) for law in AT_ONCE)
    assert newton == pytest.approx((-1 / 3, 2 / 3, 2 / 3), abs=1e-14)
    assert poisson == pytest.approx((-1 / 3, 2 / 3, 2 / 3), abs=1e-14)
    newton, poisson = (after(law, line(3), (1,) * 3, (1, 0, 0), (0.0, 1.0)) for law in AT_ONCE)
    assert newton == pytest.approx((1 / 3, 1 / 3, 1 / 3), abs=1e-14)
    assert poisson == pytest.approx((1 / 6, 1 / 6, 2 / 3), abs=1e-14)


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 1.0), st.sampled_from(sorted(LAWS)))
def test_every_law_keeps_momentum_bounces_off_and_makes_no_energy(seed, e, law):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 7))
    masses, velocities = 10.0 ** rng.uniform(-2, 2, n), rng.normal(size=n)
    found = after(law, line(n), masses, velocities, e)
    scale = float(masses @ np.abs(velocities))
    assert masses @ found == pytest.approx(float(masses @ velocities), abs=1e-13 * scale)
    assert np.diff(found).min() >= -1e-9 * np.abs(velocities).max()
    assert masses @ found**2 <= float(masses @ velocities**2) * (1.0 + 1e-12)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 1.0))
def test_one_smooth_contact_is_the_same_under_every_law(seed, e):
    rng = np.random.default_rng(seed)
    rows, motion = rng.normal(size=(1, 6)), rng.normal(size=6)
    c = Collision(rows, motion, np.zeros(1), lambda u: np.full(1, e), 1e-12)
    impulses = {name: float(law(c).impulses[0]) for name, law in LAWS.items()}
    assert list(impulses.values()) == pytest.approx([impulses["sequential"]] * len(LAWS), rel=1e-14, abs=1e-15)


def test_laws_are_refused_where_they_do_not_know_what_to_do():
    floor, ball = Body("floor", HalfSpace()), Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.0))
    with pytest.raises(Unsupported, match=r"'poisson'.*Friction"):
        begin(Scene((floor, ball), (Restitution(0.5), Friction(0.1))), Settings(impact_law="poisson"))
    begin(Scene((floor, ball), (Restitution(0.5), Friction(0.0))), Settings(impact_law="poisson"))
    uneven = Restitution(0.5, {("ball", "floor"): 0.6})
    with pytest.raises(Unsupported, match=r"'reflections'.*several"):
        begin(Scene((floor, ball), (uneven,)), Settings(impact_law="reflections"))


@pytest.mark.parametrize("law", list(LAWS))
def test_a_touching_cradle_in_the_world(law):
    balls = tuple(Body(f"b{i}", Sphere(0.5), 1.0, (i - (0.0 if i else 1.0), 0.0, 0.0),
                       velocity=(0.0 if i else 1.0, 0.0, 0.0)) for i in range(3))  # fmt: skip
    world = begin(Scene(balls, (Restitution(0.8),)), Settings(impact_law=law))
    advance(world, 1.5)
    expected = {
        **dict.fromkeys(ONE_BY_ONE, (0.091, 0.099, 0.81)),
        **dict.fromkeys(AT_ONCE, (1 / 3 - 0.8 * 2 / 3, 1 / 3 + 0.8 / 3, 1 / 3 + 0.8 / 3)),
        "reflections": (0.2 / 3, 0.2 / 3, 0.8 + 0.2 / 3),
    }[law]
    assert world.state().v[:, 0] == pytest.approx(expected, abs=1e-14)
