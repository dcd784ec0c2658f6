"""Truths of lasting contact and of bodies that turn against numbers computed elsewhere with 40 digits; see `conftest`.

Each function says what the project's own truth gives for the quantities of one entry of the catalogue.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from mechanics.rotation import IDENTITY, matrix, unrotate
from scenarios import rocking_block as rocking
from scenarios import toppling_box as toppling
from scenarios.block_on_plank import LIGHT, driven, together
from scenarios.block_on_wedge import accelerations as wedge_accelerations
from scenarios.catalogue import families
from scenarios.conveyor import carried
from scenarios.corner_drop import corner_impact
from scenarios.eccentric_impact import ARM, corner_blow
from scenarios.eccentric_impact import SPIN as CORNER_SPIN
from scenarios.eccentric_impact import VELOCITY as CORNER_VELOCITY
from scenarios.falling_rod import floor_rate, floor_time, leaves_wall
from scenarios.free_rotation import free_rotation
from scenarios.impact_laws import sequential, simultaneous
from scenarios.incline import slide
from scenarios.leaning_ladder import least_angle, wall_force
from scenarios.loaded_box import interfaces, overhang, support
from scenarios.off_the_sphere import flight_to_centre, leaving_cosine
from scenarios.rocking_block import halves
from scenarios.rolling_down import RATIOS, accelerations, needed_friction
from scenarios.sideways_launch import along_the_path
from scenarios.slab_with_balls import accelerations as slab_accelerations
from scenarios.struck_rod import MOMENT, ROD, struck
from scenarios.swing import fall_speed, fall_time
from scenarios.tilted_box import thresholds
from scenarios.tolerance import GRAVITY
from scenarios.v_groove import groove_forces, pile_thresholds

Numbers = Mapping[str, float]


def at(scenario: str, *times: float, **parameters: object):
    """Truth of a scenario at `times`."""
    return families()[scenario].of(**parameters).truth(np.array(times, dtype=np.float64))


def numbered(word: str, values: tuple[float, ...]) -> dict[str, float]:
    return {f"{word}_{k}": v for k, v in enumerate(values, 1)}


def block_thrown_up_a_slope():
    angle = math.radians(25.0)
    up, back = 4.0, slide(np.array([1.0]), angle, 0.3, 0.0)[1][0]
    time = slide(np.array([0.0]), angle, 0.3, -up)[2]
    way = -slide(np.array([time]), angle, 0.3, -up)[0][0]
    total = time + math.sqrt(2.0 * way / back)
    speed = slide(np.array([total]), angle, 0.3, -up)[1][0]
    return {"mu_threshold": math.tan(angle), "a_down": back, "a_up": up / time, "up_distance": way, "up_time": time,
            "return_speed": speed, "return_time_total": total}  # fmt: skip


def block_thrown_down_a_slope():
    angle, speed = math.radians(25.0), 3.0
    way, _, time = slide(np.array([10.0]), angle, 0.6, speed)
    return {"a_down": -speed / time, "stop_distance_from_v0_down": way[0], "stop_time_from_v0_down": time}


def block_thrown_up_a_rough_slope():
    angle, speed = math.radians(25.0), 3.0
    time = slide(np.array([0.0]), angle, 0.6, -speed)[2]
    return {"a_up": speed / time, "up_time": time, "up_distance": -slide(np.array([time]), angle, 0.6, -speed)[0][0]}


def sliding_block():
    scenario = families()["sliding-block"].of(heading=math.degrees(math.atan2(4.0, 3.0)))
    x, y, _ = scenario.truth(np.array([10.0])).x[0, 1]
    return {"time": scenario.events[0], "distance": math.hypot(x, y), "x": x, "y": y}


def across_a_slope(ratio: float) -> Numbers:
    path = along_the_path(np.array(math.tan(math.radians(15.0))), 2.0, ratio)
    return {"speed_at_phi": path.speed, "time_at_phi": path.time, "across_at_phi": path.across,
            "down_at_phi": path.down}  # fmt: skip


def sideways_launch():
    return across_a_slope(1.0)


def sideways_launch_with_less_friction():
    return across_a_slope(0.8)


def sideways_launch_in_the_end():
    return {"terminal_speed_if_r1": along_the_path(np.array(1e-20), 2.0, 1.0).speed}


def bowling(backspin: float) -> Numbers:
    scenario = families()["sliding-to-rolling"].of(speed=8.0, mu=0.12, backspin=backspin)
    truth = scenario.truth(np.array([0.0, scenario.events[0]]))
    v, w, radius = truth.v[:, 1, 0], truth.w[:, 1, 1], scenario.scene.bodies[1].shape.radius
    energy = v**2 + 0.4 * (radius * w) ** 2
    return {"time": scenario.events[0], "v_roll": v[1], "w_roll": -w[1], "distance": truth.x[1, 1, 0],
            "energy_ratio": energy[1] / energy[0]}  # fmt: skip


def sliding_to_rolling():
    return bowling(0.0)


def backspin_to_rolling():
    return bowling(50.0)


def bouncing_to_rolling():
    truth = at("bouncing-to-rolling", 2.4)
    return {"v_final": truth.v[0, 1, 0], "w_final": -truth.w[0, 1, 1]}


def rolling_down():
    slope, said = math.radians(30.0), {}
    for name, body in (("sphere", "ball"), ("cylinder", "cylinder"), ("hoop", "hoop"), ("shell", "shell")):
        pace, _ = accelerations(slope, 1.0, RATIOS[body])
        said |= {f"{name}_mu_min": needed_friction(slope, RATIOS[body]), f"{name}_acc": pace,
                 f"{name}_time": math.sqrt(4.0 / pace), f"{name}_speed": math.sqrt(4.0 * pace)}  # fmt: skip
    pace, roll = accelerations(slope, 0.1, RATIOS["ball"])
    return said | {"slip_acc": pace, "slip_sphere_R_alpha": roll}


def block_on_plank():
    speed, time, way = together(3.0, 0.25)
    return {"v_common": speed, "time": time, "slide": way, "energy_lost": 0.5 * LIGHT * 9.0 - 0.5 * 7.0 * speed**2}


def slab_with_balls():
    slab, ball = slab_accelerations(150.0, 25)
    return {"f_per_ball": ball, "a_ball": ball, "a_slab": slab, "mu_ball_min": ball / GRAVITY, "v_slab_4s": 4.0 * slab}


def off_the_sphere(ratio: float) -> Numbers:
    cosine = leaving_cosine(0.0, ratio)
    speed, place = flight_to_centre(cosine)
    return {"leave_cos": cosine, "leave_angle_deg": math.degrees(math.acos(cosine)), "leave_speed": speed,
            "landing_x_at_y0": place}  # fmt: skip


def sliding_off_the_sphere():
    return off_the_sphere(0.0)


def rolling_off_the_sphere():
    return off_the_sphere(0.4)


def box_on_base():
    grips, slip = driven(4.0, 1.5, 0.3)
    time, skid = carried(2.0, 0.3)
    # the default of the driven plank slips, the plank that is driven by less than the threshold does not
    assert len(families()["driven-plank"].of(pull=2.9).events) == 1
    assert len(families()["driven-plank"].of(pull=3.0).events) == 2
    return {"a_threshold": 0.3 * GRAVITY, "conveyor_time": time, "conveyor_skid": skid, "stick_time": grips,
            "slip_distance": slip}  # fmt: skip


def tumbled(moments: tuple[float, ...], spin: tuple[float, ...], t: float) -> Numbers:
    """Attitude with w >= 0, angular velocity in both frames, energy and angular momentum at time t."""
    q, w = (a[0] for a in free_rotation(np.array(moments), np.array(IDENTITY), np.array(spin), np.array([t])))
    body, q = unrotate(q, w), q * np.sign(q[0])
    said = {f"{name}{k}": v for name, vs in (("w_body", body), ("q", q), ("w_world", w)) for k, v in enumerate(vs)}
    return said | {"kinetic_energy": 0.5 * (moments * body**2).sum(), "L_norm": np.linalg.norm(moments * body)}


def free_symmetric_body():
    return tumbled((1.0, 1.0, 1.8), (0.3, 0.0, 2.0), 10.0)


def free_asymmetric_body():
    return tumbled((97 / 120, 41 / 60, 17 / 120), (0.1, 5.0, 0.1), 10.0)


def toppling_box():
    lands = 0.5 * math.pi - toppling.LEAN
    start = math.radians(2.0)
    return {"landing_angle_rad": lands, "w_landing": fall_speed(toppling.RATE, start, lands),
            "time": fall_time(toppling.RATE, start, lands),
            "ratio_far_edge": 1.0 - 1.5 * math.cos(toppling.LEAN) ** 2}  # fmt: skip


def loaded_box():
    total, place = support(20.0, 0.6)
    left, right = (0.5 * total * (1.0 + side * place) for side in (-1.0, 1.0))
    return {"N_total": total, "cop_x": place, "N_left_edge": left, "N_right_edge": right}


def groove():
    one, other = groove_forces(4.0, math.radians(35.0), math.radians(60.0))
    return {"N1_on_side_a": one, "N2_on_side_b": other}


def stack():
    loads = {f"N_interface_{k}": force for k, force in enumerate(interfaces([5.0, 4.0, 3.0, 2.0, 1.0]))}
    return loads | numbered("overhang", [overhang(n) for n in range(1, 6)])


def tip_or_slide():
    tips, slides = (math.degrees(a) for a in thresholds(0.3))
    return {"tip_angle_deg": tips, "slide_angle_deg": slides, "mu_equal": math.tan(math.radians(tips))}


def pile_of_balls():
    return dict(zip(("mu_balls_between", "mu_balls_floor"), pile_thresholds(), strict=True))


def corner_impact_of_a_rod(e: float, gyration: float, grips: bool) -> Numbers:
    """The catalogue counts spins counter-clockwise, which in the x-z plane is about -y."""
    mass, moment, (a, _) = 2.0, 2.0 * gyration, ARM
    blow = corner_blow(e, moment, grips)
    (vx, vz), spin = CORNER_VELOCITY, CORNER_SPIN
    before = 0.5 * mass * (vx**2 + vz**2) + 0.5 * moment * spin**2
    after = 0.5 * mass * (blow.velocity[0] ** 2 + blow.velocity[1] ** 2) + 0.5 * moment * blow.spin**2
    return {"vn_before": vz - spin * a, "j": blow.push, "vx_after": blow.velocity[0], "vy_after": blow.velocity[1],
            "w_after": -blow.spin, "vn_after": blow.velocity[1] - blow.spin * a, "energy_loss": before - after,
            "p_t": blow.rub, "p_n": blow.push, "mu_min": abs(blow.rub) / blow.push}  # fmt: skip


def rod_on_smooth_floor():
    return corner_impact_of_a_rod(0.6, 1.0 / 12.0, grips=False)


def dumbbell_on_smooth_floor():
    return corner_impact_of_a_rod(0.6, 0.25, grips=False)


def rod_that_sticks():
    return corner_impact_of_a_rod(0.0, 1.0 / 12.0, grips=True)


def struck_rod():
    after = struck(0.7, 0.4)
    left = 0.5 * ROD * after.rod**2 + 0.5 * MOMENT * after.spin**2 + 0.25 * after.ball**2
    return {"J": after.impulse, "v_rod": after.rod, "w_rod": -after.spin, "vb_after": after.ball,
            "instant_centre_below_com": after.rod / after.spin, "energy_loss": 4.0 - left}  # fmt: skip


def box_on_its_corner():
    box = families()["corner-drop"].of().scene.body("box")
    arm, v, w = corner_impact(box, 0.5)
    impulse = 3.0 * (v[2] + 2.0)
    said = {
        f"{name}{k}": a for name, vs in (("corner_r", arm), ("v_after", v), ("w_after", w)) for k, a in enumerate(vs)
    }
    turn = matrix(np.array(box.orientation))
    spin = 0.5 * w @ turn @ box.inertia_tensor @ turn.T @ w
    return said | {"j": impulse, "K": 1.5 * 2.0 / impulse, "vn_after": v[2] + np.cross(w, arm)[2],
                   "energy_loss": 6.0 - 1.5 * v @ v - spin}  # fmt: skip


def flat_landing():
    """Corners at both ends of a box of 1 m x 0.5 m and 1 kg that comes down at 2 m/s; the left one comes first."""
    j, inverse = np.array([[1.0, -0.5], [1.0, 0.5]]), np.array([1.0, 12.0 / 1.25])
    w, before, said = (j * inverse) @ j.T, np.array([-2.0, 0.0]), {}
    for e in (1.0, 0.5, 0.0):
        after = before + inverse * (j.T @ simultaneous(w, j @ before, e))
        said |= {f"L1_e{e}_v": after[0], f"L1_e{e}_w": after[1]}
        if e:
            p, count = sequential(w, j @ before, e, (0, 1))
            after = before + inverse * (j.T @ p)
            said |= {f"L2_e{e}_v": after[0], f"L2_e{e}_w": abs(after[1]), f"L2_e{e}_impacts": count}
    return said


def rocking_block():
    first, second = halves(0.1, 2)
    speed = fall_speed(rocking.RATE, rocking.LEAN - 0.1, rocking.LEAN)
    linear = math.acosh(1.0 / (1.0 - 0.1 / rocking.LEAN)) / rocking.RATE
    return {"alpha": rocking.LEAN, "p": rocking.RATE, "impact_time": first.impact, "impact_time_linear": linear,
            "w_before": speed, "ratio": rocking.KEPT, "w_after": rocking.KEPT * speed,
            "next_amplitude": second.tilt}  # fmt: skip


def block_on_wedge():
    back, along, push = wedge_accelerations(math.radians(30.0))
    return {"A_wedge": back, "a_rel": along, "N": push}


def ladder_on_a_wall():
    push = wall_force(math.radians(65.0), 0.0)
    smooth, rough = (math.degrees(least_angle(0.4, mu)) for mu in (0.0, 0.3))
    return {"min_angle_smooth_wall_deg": smooth, "min_angle_rough_wall_deg": rough, "wall_force_smooth_at_th": push,
            "mu_needed_at_th": push / (10.0 * GRAVITY)}  # fmt: skip


def falling_rods():
    start = math.radians(20.0)
    spin, time = floor_rate(start, 0.0, 0.5 * math.pi), floor_time(start, 0.5 * math.pi)
    angle, rate, speed = leaves_wall(start)
    return {"a_w_at_floor": spin, "a_time_to_floor": time, "a_com_speed_at_floor": 0.5 * spin,
            "c_leave_cos": math.cos(angle), "c_leave_w": rate, "c_final_vx": speed}  # fmt: skip


ENTRIES: dict[str, Callable[[], Numbers]] = {
    "D01": block_thrown_up_a_slope,
    "D01-stops": block_thrown_down_a_slope,
    "D01-threw-up": block_thrown_up_a_rough_slope,
    "D02": sliding_block,
    "D03": sideways_launch,
    "D03-r0.8": sideways_launch_with_less_friction,
    "D03-limit": sideways_launch_in_the_end,
    "D04": sliding_to_rolling,
    "D04-backspin": backspin_to_rolling,
    "D05": bouncing_to_rolling,
    "D06": rolling_down,
    "D07": block_on_plank,
    "D08": slab_with_balls,
    "D12": sliding_off_the_sphere,
    "D12-rolls": rolling_off_the_sphere,
    "D15": box_on_base,
    "E04": free_symmetric_body,
    "E05": free_asymmetric_body,
    "E14": toppling_box,
    "F01": loaded_box,
    "F02": groove,
    "F03": stack,
    "F05": tip_or_slide,
    "F07": pile_of_balls,
    "G01": rod_on_smooth_floor,
    "G01-dumbbell": dumbbell_on_smooth_floor,
    "G02": rod_that_sticks,
    "G03": struck_rod,
    "G04": box_on_its_corner,
    "G05": flat_landing,
    "G06": rocking_block,
    "D13": block_on_wedge,
    "F04": ladder_on_a_wall,
    "G09": falling_rods,
}


def test_the_truth_has_the_printed_number(compute, quantity, printed):
    assert float(compute()[quantity]) == printed
