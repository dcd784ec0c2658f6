"""Truths of tops, whirling and struck pendula, loops and leaning bodies against numbers with 40 digits; see `conftest`.

Each function says what the project's own truth gives for the quantities of one entry of the catalogue.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from scenarios import card_house, heavy_top, loop_on_a_string, pile_of_logs, pushed_box, spherical_pendulum
from scenarios import spinning_top as top
from scenarios import struck_pendulum as hinged
from scenarios.pendulum import RATES
from scenarios.swing import whirl, whirl_time
from scenarios.tolerance import GRAVITY

Numbers = Mapping[str, float]


def loop(ratio: float) -> Numbers:
    height = 2.0 * loop_on_a_string.RADIUS
    slack = loop_on_a_string.lets_go(height, ratio)
    return {"H_min": loop_on_a_string.least_height(ratio), "leave_cos": slack.cosine, "leave_speed": slack.speed,
            "leave_angle_rad": math.acos(slack.cosine),
            "N_bottom_over_mg": loop_on_a_string.pull_at_the_bottom(height, ratio)}  # fmt: skip


def whirling_rod() -> Numbers:
    spin, rate = 9.0, RATES["rod"]
    turn, speed = whirl(np.array([3.0]), rate, spin)
    return {"turn_time": 2.0 * whirl_time(rate, spin, math.pi), "theta(t)": turn[0], "theta_dot(t)": speed[0],
            "min_rate": math.sqrt(spin**2 - 4.0 * rate**2)}  # fmt: skip


def steady_top() -> Numbers:
    slow, fast = top.steady(top.TILT, top.SPIN)
    way = heavy_top.axis(top.released(top.TILT, top.SPIN, slow), np.zeros(1))
    w = heavy_top.attitude(way)[1][0]
    return {"slow": slow, "fast": fast, "spin_for_slow": way.psi_rate[0], "sleeping_w3": top.sleeping_spin()} | {
        f"w_world_slow_at_phi0{k}": w[k] for k in range(3)
    }


def nutating_top() -> Numbers:
    release = top.released(top.TILT, top.SPIN, 0.0)
    way = heavy_top.nodding(release)
    then, after = (heavy_top.axis(release, np.array([t])) for t in (1.0, way.period))
    return {"nutation_period": way.period, "theta_min": math.acos(way.high), "theta_max": math.acos(way.low),
            "theta(t)": math.acos(then.u[0]), "phi(t)": then.phi[0], "phi_per_nutation": after.phi[0],
            "mean_precession": after.phi[0] / way.period}  # fmt: skip


def spherical_bob() -> Numbers:
    cone = math.radians(40.0)
    rate = math.sqrt(GRAVITY / math.cos(cone))
    level = heavy_top.nodding(spherical_pendulum.hung(cone, rate * math.sin(cone)))
    assert level.high - level.low < 1e-15
    release = spherical_pendulum.hung(math.radians(60.0), 1.0)
    way = heavy_top.nodding(release)
    then, after = (heavy_top.axis(release, np.array([t])) for t in (3.0, way.period))
    return {"cone_rate": rate, "cone_tension_over_mg": 1.0 / math.cos(cone), "z_period": way.period,
            "theta_down_min": math.pi - math.acos(way.low), "theta_down_max": math.pi - math.acos(way.high),
            "azimuth_per_z_period": after.phi[0], "theta_down(t)": math.pi - math.acos(then.u[0]),
            "azimuth(t)": then.phi[0]}  # fmt: skip


def struck_pendulum(e: float, depth: float) -> Numbers:
    blow = hinged.struck(e, depth)
    return {"w_after": blow.spin, "vb_after": blow.ball, "impulse": blow.impulse, "hinge_impulse": blow.hinge,
            "percussion_x": 2.0 * hinged.ABOUT_HINGE / (hinged.ROD * hinged.LENGTH)}  # fmt: skip


def pushed() -> Numbers:
    slides, tips = pushed_box.thresholds(0.3, 0.8)
    return {"push_slide_force": slides, "push_tip_force": tips, "push_height_equal": pushed_box.height_where_both(0.3)}


def cards() -> Numbers:
    force, weight = card_house.apex_force(math.radians(25.0), 0.0), card_house.MASS * GRAVITY
    return {"mu_min_cards": force / weight, "apex_force": force, "floor_N": weight}


def logs() -> Numbers:
    return dict(zip(("mu_logs_between", "mu_logs_floor"), pile_of_logs.thresholds(), strict=True))


ENTRIES: dict[str, Callable[[], Numbers]] = {
    "D11": partial(loop, 0.0),
    "D11-rolls": partial(loop, 0.4),
    "E02": whirling_rod,
    "E06": steady_top,
    "E07": nutating_top,
    "E08": spherical_bob,
    "E11": partial(struck_pendulum, 0.5, 0.9),
    "E11-e0": partial(struck_pendulum, 0.0, 0.9),
    "E11-percussion": partial(struck_pendulum, 0.5, 0.8),
    "F05-push": pushed,
    "F06": cards,
    "F07-logs": logs,
}


def test_the_truth_has_the_printed_number(compute, quantity, printed):
    assert float(compute()[quantity]) == printed
