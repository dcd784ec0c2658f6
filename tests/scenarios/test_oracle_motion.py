"""Truths of tops, whirling and struck pendula, loops and leaning bodies against numbers with 40 digits; see `conftest`.

Each function says what the project's own truth gives for the quantities of one entry of the catalogue.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from mechanics.rotation import IDENTITY, rotate, unrotate
from scenarios import (
    card_house,
    heavy_top,
    loop_on_a_string,
    pile_of_logs,
    pushed_box,
    spherical_pendulum,
    sprung_plate,
)
from scenarios import free_rotation as closed
from scenarios import rimless_wheel as rimless
from scenarios import slipping_rod as rod
from scenarios import spinning_top as top
from scenarios import struck_pendulum as hinged
from scenarios import wheel_and_step as step
from scenarios.catalogue import families
from scenarios.damped_spring import damped
from scenarios.pendulum import ARMS, RATES
from scenarios.swing import fall_speed, swing, whirl, whirl_time
from scenarios.tethered_ball import taut
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


def spring_and_damper() -> Numbers:
    way = damped(1e5, 40.0)
    ends = np.array([way.back(), way.unloaded(), way.farthest()])
    x, v = way.struck(ends, 1.0)
    return {"zeta": way.zeta, "duration_until_x0": ends[0], "e_until_x0": -v[0], "duration_until_F0": ends[1],
            "e_until_F0": -v[1], "max_penetration": x[2], "time_of_max": ends[2],
            "static_sink": GRAVITY / way.rate**2}  # fmt: skip


def vibrating_plate() -> Numbers:
    way = sprung_plate.thrown(0.05, 20.0, 0.0)
    return {"liftoff_time": way.leaves, "liftoff_speed": way.speed, "reimpact_time": way.meets,
            "top_height": way.height + 0.5 * way.speed**2 / GRAVITY, "reimpact_rel_speed": way.closing}  # fmt: skip


def wheel_at_a_step() -> Numbers:
    speed, height = 2.0, 0.06
    return {"wheel_w_after": step.bumped(speed, height), "wheel_v_climb_min": step.least_speed(height),
            "wheel_speed_on_top": math.sqrt(step.on_top(speed, height))}  # fmt: skip


def rimless_wheel(ratio: float) -> Numbers:
    cycle = rimless.walk(0.08, ratio)
    way = 2.0 * rimless.LENGTH * math.sin(rimless.STEP_ANGLE)
    return {"eta": cycle.kept, "w_before": cycle.before, "w_after": cycle.after, "step_period": cycle.period,
            "mean_speed": way / cycle.period}  # fmt: skip


def rod_from_upright(mu: float) -> Numbers:
    return {"b_mu_critical": rod.least_forward(), "b_slip_angle_deg": math.degrees(rod.slips(1e-8, mu))}


def pushed_rod(degrees: float, rate: float) -> Numbers:
    """The catalogue counts angles from the floor."""
    mu, angle = 1.6, math.radians(90.0 - degrees)
    begin, end = (math.degrees(a) for a in rod.paradox(mu))
    said = {"mu_min_for_paradox": rod.least_paradox(math.atan(0.5)), "tan_th_at_min": math.tan(rod.paradox(4 / 3)[0]),
            "mu_P(th)": rod.least_paradox(angle), "th_paradox_from_deg": begin, "th_paradox_to_deg": end,
            "p": rod.contact_mobility(angle, -mu), "b": rod.unsupported(angle, rate)}  # fmt: skip
    return said | ({"N": rod.push(angle, rate, -mu)} if said["p"] > 0.0 else {})


def floor_below_piles() -> Numbers:
    """Floor forces over the weight of one body: the whole weight over the bodies on the floor."""
    return {"floor_N_logs_over_W": 3.0 / 2.0, "floor_N_balls_over_W": 4.0 / 3.0}


def swung(kind: str) -> Numbers:
    turn, rate = swing(np.array([5.0]), RATES[kind], math.radians(120.0))
    return {"theta(t)": turn[0], "theta_dot(t)": rate[0]}


def double_pendulum() -> Numbers:
    bodies = families()["double-pendulum"].of().scene.bodies
    return {"energy": sum(b.mass * GRAVITY * b.position[2] for b in bodies if not b.fixed)}


def cones_of_a_free_body() -> Numbers:
    """Rates from where axis and spin are a quarter of a second later."""
    moments, spin, time = np.array([1.0, 1.0, 1.8]), np.array([0.3, 0.0, 2.0]), 0.25
    q, w = (a[0] for a in closed.free_rotation(moments, np.array(IDENTITY), spin, np.array([time])))
    body, momentum = unrotate(q, w), moments * spin
    along = momentum / np.linalg.norm(momentum)
    aside = [a - (a @ along) * along for a in (np.eye(3)[2], rotate(q, np.eye(3)[2]))]
    turned = math.atan2(np.cross(aside[0], aside[1]) @ along, aside[0] @ aside[1])
    return {"body_rate": math.atan2(body[1], body[0]) / time, "space_precession_rate": turned / time,
            "half_cone_space_rad": math.atan2(np.linalg.norm(aside[0]), along[2])}  # fmt: skip


def cycle_of_a_free_body() -> Numbers:
    moments, spin = np.array([97 / 120, 41 / 60, 17 / 120]), np.array([0.1, 5.0, 0.1])
    cycle, momentum = closed._cycle(moments, spin), moments * spin
    quarter, size = closed._quarter(cycle.rest), float(np.linalg.norm(momentum))
    u, turns = np.array([0.0, 2.0 * quarter]), np.array([0.0, 1.0])
    start, end = closed._precession(moments[list(cycle.order)], size, cycle, u, np.zeros(2), np.ones(2), turns)
    period, (v, energy) = 4.0 * quarter / abs(cycle.rate), (np.array([-2.0, 2.0, 8.0]), 0.5 * momentum @ spin)
    # the catalogue follows an axis that turns over meanwhile, which is half a turn less than one that does not
    return {"w_period": period, "half_period_flip": 0.5 * period, "elliptic_m": 1.0 - cycle.rest,
            "phi_per_half_period": abs(end - start) - math.pi, "total_energy_v0_(-2,2,8)_m10": 5.0 * v @ v + energy} | {
            f"L_world{k}": momentum[k] for k in range(3)}  # fmt: skip


def hinge_of_a_falling_rod() -> Numbers:
    """Newton's law for the centre where the rod is level: ω² L/2 along it, g less 3g/4 across."""
    spin = fall_speed(RATES["rod"], math.radians(5.0), 0.5 * math.pi)
    turn = RATES["rod"] ** 2
    return {"axial_force_over_mg": -(spin**2) * ARMS["rod"] / GRAVITY,
            "transverse_force_over_mg": 1.0 - turn * ARMS["rod"] / GRAVITY}  # fmt: skip


def dumbbell() -> Numbers:
    scenario = families()["dumbbell"].of()
    one, other = (b for b in scenario.scene.bodies if not b.fixed)
    reduced, truth = one.mass * other.mass / (one.mass + other.mass), scenario.truth(np.zeros(1))
    apart, parting = truth.x[0, 1] - truth.x[0, 0], truth.v[0, 1] - truth.v[0, 0]
    return {"tension": reduced * parting @ parting / np.linalg.norm(apart),
            "L_about_com": reduced * np.linalg.norm(np.cross(apart, parting))}  # fmt: skip


def taut_string() -> Numbers:
    speed = taut(0.0).velocity
    return {"tension_after_e0": speed @ speed / 2.0}


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
    "C12-tension": taut_string,
    "C13": spring_and_damper,
    "D14": vibrating_plate,
    "E01-then": partial(swung, "rod"),
    "E01-bob-then": partial(swung, "bob"),
    "E03-energy": double_pendulum,
    "E04-cones": cones_of_a_free_body,
    "E05-cycle": cycle_of_a_free_body,
    "E12-forces": hinge_of_a_falling_rod,
    "E13-tension": dumbbell,
    "F07-floor": floor_below_piles,
    "G07": wheel_at_a_step,
    "G08": partial(rimless_wheel, 0.0),
    "G08-heavy": partial(rimless_wheel, 0.5),
    "G09-slips": partial(rod_from_upright, 0.3),
    "G09-slips0.6": partial(rod_from_upright, 0.6),
    "G10": partial(pushed_rod, 30.0, 0.0),
    "G10-inconsistent": partial(pushed_rod, 60.0, 0.0),
    "G10-indeterminate": partial(pushed_rod, 60.0, 6.0),
}


def test_the_truth_has_the_printed_number(compute, quantity, printed):
    assert float(compute()[quantity]) == printed
