"""Every truth against numbers computed elsewhere with 40 digits, one row per number.

The numbers are those of a catalogue of closed forms that was evaluated in 40-digit arithmetic and checked by a
second route for each entry; they are printed with up to 17 digits.  An entry is a subject (A01: free fall ...),
and its function says what the project's own truth gives for each of its quantities.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial

import numpy as np
import pytest

from mechanics.rotation import IDENTITY, matrix, unrotate
from mechanics.scene import Scene
from scenarios import rocking_block as rocking
from scenarios import toppling_box as toppling
from scenarios.block_on_plank import LIGHT, driven, together
from scenarios.bouncing_ball import bounce, impact_times
from scenarios.bouncing_to_rest import path_length, rest_time
from scenarios.catalogue import families
from scenarios.converging_walls import hits
from scenarios.conveyor import carried
from scenarios.corner_drop import corner_impact
from scenarios.eccentric_impact import ARM, corner_blow
from scenarios.eccentric_impact import SPIN as CORNER_SPIN
from scenarios.eccentric_impact import VELOCITY as CORNER_VELOCITY
from scenarios.free_rotation import free_rotation
from scenarios.gapped_chain import MASSES, PLACES, SPEEDS
from scenarios.head_on_collision import after_collision
from scenarios.impact_laws import sequential, simultaneous, smooth_contacts
from scenarios.incline import slide
from scenarios.incline_bounce import impacts_down
from scenarios.inelastic_collapse import CRITICAL, history
from scenarios.loaded_box import interfaces, overhang, support
from scenarios.off_the_sphere import flight_to_centre, leaving_cosine
from scenarios.on_a_line import balls_on_a_line, impacts_in_turn
from scenarios.rectangle_billiard import HEIGHT, START, VELOCITY, WIDTH, back_and_forth, turns
from scenarios.rocking_block import halves
from scenarios.rolling_down import RATIOS, accelerations, needed_friction
from scenarios.rough_bounce import MASS, RADIUS, RATIO, after_bounce
from scenarios.rough_collision import after_contact
from scenarios.sideways_launch import along_the_path
from scenarios.slab_with_balls import accelerations as slab_accelerations
from scenarios.stacked_drop import launched
from scenarios.sticking_train import couplings
from scenarios.struck_rod import MOMENT, ROD, struck
from scenarios.swing import fall_speed, fall_time
from scenarios.symmetric_break import PAIRS
from scenarios.tilted_box import thresholds
from scenarios.tolerance import GRAVITY
from scenarios.v_groove import groove_forces, pile_thresholds
from scenarios.wedge_billiard import in_wedge, reflections

Numbers = Mapping[str, float]
ENTRIES: dict[str, tuple[Callable[[], Numbers], Numbers, float]] = {}
DIGITS = 4e-14  # relative: what double arithmetic keeps of 17 printed digits over a dozen operations


def entry(name: str, loss: float = 1.0, **printed: float) -> Callable[[Callable[[], Numbers]], Callable[[], Numbers]]:
    """Enter the decorated function with the `printed` numbers of its quantities; cancellation costs a factor `loss`."""

    def enter(compute: Callable[[], Numbers]) -> Callable[[], Numbers]:
        ENTRIES[name] = compute, printed, loss * DIGITS
        return compute

    return enter


def at(scenario: str, *times: float, **parameters: object):
    """Truth of a scenario at `times`."""
    return families()[scenario].of(**parameters).truth(np.array(times, dtype=np.float64))


def rows() -> list:
    return [
        pytest.param(compute, printed, quantity, digits, id=f"{name}-{quantity}")
        for name, (compute, printed, digits) in ENTRIES.items()
        for quantity in printed
    ]


@entry(
    "A01", y=8.96375, v=-14.715, t_ground=2.0192751093846089, v_ground=-19.809088823063013, y_ground=0.0
)  # fmt: skip
def free_fall():
    ground = math.sqrt(2.0 * 20.0 / GRAVITY)
    truth = at("free-fall", 1.5, ground)
    return {"y": truth.x[0, 0, 2], "v": truth.v[0, 0, 2], "t_ground": ground, "v_ground": truth.v[1, 0, 2],
            "y_ground": truth.x[1, 0, 2]}  # fmt: skip


@entry("A02", range=66.134487304910092, apex_height=16.161821838893184, impact_vx=19.151111077974451,
       impact_vy=-17.807159921758558, apex_vy=0.0)  # fmt: skip
def projectile():
    truth = at("projectile", 3.453297672163307, 1.6380927871726283)
    return {"range": truth.x[0, 0, 0], "apex_height": truth.x[1, 0, 2], "impact_vx": truth.v[0, 0, 0],
            "impact_vy": truth.v[0, 0, 2], "apex_vy": truth.v[1, 0, 2]}  # fmt: skip


@entry("A03", exact=-4.905, semi_implicit_euler=-4.9254375, explicit_euler=-4.8845625, offset=0.0204375)
def integrator_fingerprint():
    """The offset g t h/2 that the tolerance of free fall is made of, here at a step of 1/240 s."""
    check = families()["free-fall"].of().checks[0]
    offset = check.tolerance / 1.5 / 1.5 * 1000.0 / 240.0  # from 1.5 s, safety 1.5 and a step of 1 ms
    fall = at("free-fall", 1.0).x[0, 0, 2] - 20.0
    return {"exact": fall, "offset": offset, "semi_implicit_euler": fall - offset, "explicit_euler": fall + offset}


@entry("B01", impact_time_1=0.4515236409857309, impact_time_2=1.1739614665629004, impact_time_3=1.7519117270246359,
       impact_time_4=2.2142719353940244, impact_time_5=2.5841601020895351, apex_height_1=0.64, apex_height_2=0.4096,
       apex_height_3=0.262144, apex_height_4=0.16777216, apex_height_5=0.1073741824, zeno_time=4.0637127688715781,
       path_length=4.5555555555555556, velocity_sum=39.865022262630182)  # fmt: skip
def bouncing_ball():
    e, times = 0.8, impact_times(1.0, 0.8, math.inf)
    apex = times[:5] + e ** np.arange(1, 6) * math.sqrt(2.0 / GRAVITY)
    heights = bounce(apex, 1.0, e)[0]
    said = {f"impact_time_{k + 1}": times[k] for k in range(5)} | {f"apex_height_{k + 1}": heights[k] for k in range(5)}
    # each impact at speed v changes the velocity by (1 + e) v
    changes = (1.0 + e) * math.sqrt(2.0 * GRAVITY) / (1.0 - e)
    return said | {"zeno_time": rest_time(1.0, e), "path_length": path_length(1.0, e), "velocity_sum": changes}


@entry("B02", distance_1=1.3680805733026749, distance_2=4.1042417199080248, distance_3=8.2084834398160496,
       distance_4=13.680805733026749, distance_5=20.521208599540124)  # fmt: skip
def bouncing_down_a_slope():
    _, places = impacts_down(math.radians(20.0), 1.0)
    return {f"distance_{k}": places[k] for k in range(1, 6)}


@entry("B02-e0.7", distance_1=0.81400794111509158, distance_2=1.7826773910420506, distance_3=2.6561893126526553,
       distance_4=3.3634148780443281, distance_5=3.9053987117479812, sliding_starts_at_distance=5.3203133406215136,
       sliding_starts_after_first_impact=1.4899519992329022)  # fmt: skip
def bouncing_down_a_slope_with_losses():
    slope, e = math.radians(20.0), 0.7
    times, places = impacts_down(slope, e)
    last = times[0] * (1.0 + e) / (1.0 - e)  # where the impacts accumulate
    return {f"distance_{k}": places[k] for k in range(1, 6)} | {
        "sliding_starts_at_distance": 0.5 * GRAVITY * math.sin(slope) * (last**2 - times[0] ** 2),
        "sliding_starts_after_first_impact": last - times[0],
    }


@entry("B03", **{f"hit_{k}_{what}": value for k, values in enumerate([
    (1.7142857142857143, 0.57142857142857143, 4.0), (1.3333333333333333, 1.3333333333333333, 5.0),
    (1.0909090909090909, 1.8181818181818182, 6.0), (0.92307692307692308, 2.1538461538461538, 7.0),
    (0.8, 2.4, 8.0)], 1) for what, value in zip(("position", "time", "speed_after"), values, strict=True)})  # fmt: skip
def converging_walls():
    columns = zip(("position", "time", "speed_after"), hits(5), strict=True)
    return {f"hit_{k + 1}_{what}": column[k] for what, column in columns for k in range(5)}


@entry("B04", x=1.67, y=0.81612649542720728, vx=1.9, vy=-1.8384776310850236, hits_x_walls=108, hits_y_walls=179)
def rectangle_billiard():
    t = 97.3
    sides = [(WIDTH, START[0], VELOCITY[0]), (HEIGHT, START[1], VELOCITY[1])]
    (x, u), (y, w) = (back_and_forth(np.array(t), *side) for side in sides)
    counts = [len(turns(*side, t)) for side in sides]
    return {"x": x, "y": y, "vx": u, "vy": w, "hits_x_walls": counts[0], "hits_y_walls": counts[1]}


@entry("B05", hits=10, exit_direction_rad=0.17453292519943296, min_distance=0.5)
def wedge_billiard():
    wedge, start = math.radians(17.0), (3.0, 0.5)
    end = in_wedge(np.array([3.0, 1e3]), wedge, start, 1.0)
    return {"hits": len(reflections(wedge, start, 1.0)), "exit_direction_rad": math.atan2(end.v[1, 1], end.v[1, 0]),
            "min_distance": np.hypot(*end.x[0])}  # fmt: skip


def head_on(m1: float, m2: float, v1: float, v2: float) -> Numbers:
    u1, u2 = after_collision(m1, m2, v1, v2, 0.6)
    light = 1 if m1 < m2 else 2  # the loss of energy is read from the light body and the relative motion
    reduced = m1 * m2 / (m1 + m2)
    loss = 0.5 * reduced * ((v1 - v2) ** 2 - (u1 - u2) ** 2)
    push = abs(u1 - v1) * m1 if light == 1 else abs(u2 - v2) * m2
    return {"v1_after": u1, "v2_after": u2, "impulse": push, "energy_loss": loss}


@entry("C01", v1_after=-1.999996000004, v2_after=-0.499996000004, impulse=3.999996000004, energy_loss=1.999998000002)
def head_on_light():
    return head_on(1.0, 1e6, 2.0, -0.5)


@entry("C01-swap", v1_after=1.999996000004, v2_after=3.499996000004, impulse=3.999996000004, energy_loss=1.999998000002)
def head_on_heavy():
    return head_on(1e6, 1.0, 2.0, -0.5)


@entry("C02", impulse=3.2908965343808669, v1x=1.575, v1y=0.82272413359521671, v2x=2.85, v2y=-1.6454482671904334,
       angle1_rad=0.48137873803326776, angle2_rad=-0.52359877559829887, energy_loss=0.4275)  # fmt: skip
def oblique_collision():
    one, two = at("oblique-collision", 1.0).v[0]
    return {"impulse": np.linalg.norm(two), "v1x": one[0], "v1y": one[2], "v2x": two[0], "v2y": two[2],
            "angle1_rad": math.atan2(one[2], one[0]), "angle2_rad": math.atan2(two[2], two[0]),
            "energy_loss": 9.0 - one @ one - 0.5 * two @ two}  # fmt: skip


def rough_bounce(mu: float) -> Numbers:
    """The catalogue counts spins counter-clockwise, which in the x-z plane is about -y."""
    e, v, spin = 0.8, (2.0, -3.0), -10.0
    along, up, turn = after_bounce(mu, e, v, spin, RATIO)
    moment = RATIO * MASS * RADIUS**2
    before, after = (0.5 * MASS * (a * a + b * b) + 0.5 * moment * w * w for a, b, w in ((*v, spin), (along, up, turn)))
    slip = v[0] - RADIUS * spin
    return {"Jn": MASS * (up - v[1]), "Jt": MASS * (along - v[0]), "vx_after": along, "vy_after": up, "w_after": -turn,
            "slip_after": along - RADIUS * turn, "energy_loss": before - after,
            "mu_critical": RATIO * slip / ((1.0 + RATIO) * (1.0 + e) * -v[1])}  # fmt: skip


@entry("C03", Jn=2.7, Jt=-0.27, vx_after=1.46, vy_after=2.4, w_after=-3.5, slip_after=1.11,
       mu_critical=0.15873015873015873, energy_loss=1.36485)  # fmt: skip
def rough_bounce_that_slips():
    return rough_bounce(0.1)


@entry("C03-sticks", Jn=2.7, Jt=-0.42857142857142857, vx_after=1.1428571428571429, vy_after=2.4,
       w_after=-11.428571428571429, slip_after=0.0, energy_loss=1.4528571428571429)  # fmt: skip
def rough_bounce_that_sticks():
    return rough_bounce(0.6)


def rough_pair(mu: float) -> Numbers:
    along, across, spins = after_contact(0.7, mu)
    slip = across[0] - across[1] - 0.2 * spins[0] - 0.3 * spins[1]
    return {"Jn": 4.0 - along[0], "Jt": across[0], "v1x": along[0], "v1y": across[0], "w1_after": -spins[0],
            "v2x": along[1], "v2y": across[1], "w2_after": -spins[1], "slip_after": slip}  # fmt: skip


@entry("C04", Jn=5.1, Jt=-0.765, v1x=-1.1, v1y=-0.765, w1_after=22.35, v2x=1.7, v2y=0.255, w2_after=-6.7,
       slip_after=1.44)  # fmt: skip
def rough_pair_that_slips():
    return rough_pair(0.15)


@entry("C04-sticks", Jn=5.1, Jt=-1.125, v1x=-1.1, v1y=-1.125, w1_after=18.75, v2x=1.7, v2y=0.375, w2_after=-7.5,
       slip_after=0.0)  # fmt: skip
def rough_pair_that_sticks():
    return rough_pair(1.0)


def row(count: int, moving: int, e: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """J, W and velocities of equal balls of 1 kg in a row that touch, the first `moving` at 1 m/s."""
    balls = balls_on_a_line(0.1, [1.0] * count, [0.0] * count, [1.0] * moving + [0.0] * (count - moving))
    pairs = [(f"ball-{k}", f"ball-{k + 1}") for k in range(1, count)]
    j, inverse = smooth_contacts(Scene(balls), pairs)
    return j, (j * inverse) @ j.T, np.array([b.velocity for b in balls]).ravel()


def row_after(count: int, moving: int, law: str, e: float = 1.0) -> np.ndarray:
    j, w, v = row(count, moving, e)
    p = simultaneous(w, j @ v, e) if law == "L1" else sequential(w, j @ v, e, range(count - 1))[0]
    return (v + j.T @ p)[::3]


CRADLES = {
    "L1_n2_k1": (0.0, 1.0), "L2_n2_k1": (0.0, 1.0), "L1_n3_k1": (-1 / 3, 2 / 3, 2 / 3), "L2_n3_k1": (0, 0, 1),
    "L1_n4_k1": (-0.5, 0.5, 0.5, 0.5), "L2_n4_k1": (0, 0, 0, 1), "L1_n5_k1": (-0.6, 0.4, 0.4, 0.4, 0.4),
    "L2_n5_k1": (0, 0, 0, 0, 1), "L1_n5_k2": (-0.2, -0.2, 0.8, 0.8, 0.8), "L2_n5_k2": (0, 0, 0, 1, 1),
}  # fmt: skip


@entry("C05", **{f"{name}_ball{k}": v for name, vs in CRADLES.items() for k, v in enumerate(vs)})
def cradle():
    said = {}
    for name in CRADLES:
        law, count, moving = name.split("_")
        after = row_after(int(count[1]), int(moving[1]), law)
        said |= {f"{name}_ball{k}": v for k, v in enumerate(after)}
    return said


@entry("C05-e0.9", ball0=0.04352508203125, ball1=0.04537296484375, ball2=0.047296640625, ball3=0.0492990625,
       ball4=0.81450625, impacts=10)  # fmt: skip
def cradle_with_losses():
    j, w, v = row(5, 1, 0.9)
    _, count = sequential(w, j @ v, 0.9, range(4))
    return {f"ball{k}": v for k, v in enumerate(row_after(5, 1, "L2", 0.9))} | {"impacts": count}


def chain(e: Fraction) -> Numbers:
    exact = [[Fraction(v) for v in values] for values in (MASSES, PLACES, SPEEDS)]
    sequence = impacts_in_turn(*exact, e)
    order = {f"pair_{k + 1}": i.pair for k, i in enumerate(sequence)}
    times = {f"time_{k + 1}": float(i.time) for k, i in enumerate(sequence)}
    return order | times | {f"v{k}": float(v) for k, v in enumerate(sequence[-1].velocities)} | {"hits": len(sequence)}


def numbered(word: str, values: tuple[float, ...]) -> dict[str, float]:
    return {f"{word}_{k}": v for k, v in enumerate(values, 1)}


@entry("C06", hits=7, v0=-11 / 9, v1=49 / 27, v2=61 / 27, v3=8 / 3, **numbered("pair", (0, 1, 2, 1, 0, 2, 1)),
       **numbered("time", (1 / 3, 7 / 12, 83 / 114, 5 / 6, 13 / 12, 1.5, 67 / 12)))  # fmt: skip
def elastic_chain():
    return chain(Fraction(1))


@entry("C06-e0.5", hits=9, v0=0.75, v1=111 / 128, v2=15 / 16, v3=71 / 64,
       **numbered("pair", (0, 1, 2, 1, 2, 0, 1, 2, 1)),
       **numbered("time", (1 / 3, 2 / 3, 7 / 8, 47 / 48, 19 / 16, 21 / 16, 235 / 144, 159 / 80,
       491 / 144)))  # fmt: skip
def chain_with_losses():
    return chain(Fraction(1, 2))


GALPERIN = (
    (3, 2, 1.0, 0.0),
    (31, 16, 0.99885759556311843, 0.47786020820588592),
    (314, 157, 0.99999855956297771, 0.16973131619503998),
    (3141, 1571, 0.99999991746053095, 0.40629906632325765),
    (31415, 15708, 0.99999999997309201, 0.073359382067585709),
)


def galperin(d: int) -> Numbers:
    root = 10.0**d
    wedge, start = math.atan(1.0 / root), (2.0 * root, 1.0)
    count = len(reflections(wedge, start, root))
    scaled, light = in_wedge(np.array([1e6]), wedge, start, root).v[0]
    return {"collisions": count, "block_block_hits": (count + 1) // 2, "V_heavy": scaled / root, "v_light": light}


for d, values in enumerate(GALPERIN):
    # the light block's velocity is the sine of a small angle times √(M/m), and loses that many digits
    names = ("collisions", "block_block_hits", "V_heavy", "v_light")
    entry(f"C07-d{d}", 10.0**d, **dict(zip(names, values, strict=True)))(partial(galperin, d))


@entry("C08", **numbered("t", (0.5, 1.5, 3.0, 5.0, 7.5)), **numbered("v_train", (1.0, 2 / 3, 0.5, 0.4, 1 / 3)))
def sticking_train():
    times = couplings(6)
    truth = at("sticking-train", *times)
    return numbered("t", times) | numbered("v_train", truth.v[:, 0, 0])


@entry("C09", e_critical=0.071796769724490826, collapse_time=0.55555555555555556, collapse_position=1.0518518518518519,
       common_velocity=1 / 3)  # fmt: skip
def inelastic_collapse():
    last = history(0.05)[-1]
    return {"e_critical": CRITICAL, "collapse_time": last.time, "collapse_position": last.places[1],
            "common_velocity": last.velocities[1]}  # fmt: skip


def three_ball_break(e: float) -> Numbers:
    laws = families()["symmetric-break"].of(e=e).laws
    one, other = np.array(laws["simultaneous"]), np.array(laws["sequential, upper first"])
    assert PAIRS[0] == ("cue", "upper")
    return {"L1_impulse": np.linalg.norm(one[1]), "L1_cue_vx": one[0, 0], "L1_target_speed": np.linalg.norm(one[1]),
            "L1_target_vx": one[1, 0], "L1_target_vy": one[1, 2], "L1_energy_ratio": (one**2).sum(),
            "L2_cue_vx": other[0, 0], "L2_cue_vy": other[0, 2], "L2_first_target_speed": np.linalg.norm(other[1]),
            "L2_second_target_speed": np.linalg.norm(other[2])}  # fmt: skip


@entry("C10", L1_impulse=0.69282032302755092, L1_cue_vx=-0.2, L1_target_speed=0.69282032302755092, L1_target_vx=0.6,
       L1_target_vy=0.34641016151377546, L1_energy_ratio=1.0, L2_cue_vx=-0.125, L2_cue_vy=-0.21650635094610966,
       L2_first_target_speed=0.86602540378443865, L2_second_target_speed=0.43301270189221932)  # fmt: skip
def symmetric_break():
    return three_ball_break(1.0)


@entry("C10-e0.5", L1_impulse=0.51961524227066319, L1_cue_vx=0.1, L1_target_speed=0.51961524227066319,
       L1_target_vx=0.45, L1_target_vy=0.25980762113533159, L1_energy_ratio=0.55, L2_cue_vx=0.0859375,
       L2_cue_vy=-0.12178482240718668, L2_first_target_speed=0.64951905283832899,
       L2_second_target_speed=0.40594940802395562)  # fmt: skip
def symmetric_break_with_losses():
    return three_ball_break(0.5)


@entry("C11", v_top=10.569274329256187, v_big=3.8365150137897561, rise_top=5.6936574845603372)
def stacked_drop():
    shot = launched(0.0)
    return {"v_top": shot.small, "v_big": shot.big, "rise_top": shot.small**2 / (2.0 * GRAVITY)}


@entry(
    "D01",
    mu_threshold=0.46630765815499859,
    a_down=1.4786213304274006,
    a_up=6.8131489649251223,
    up_distance=1.1742000712423762,
    up_time=0.58710003562118808,
    return_speed=1.8634362192081332,
    return_time_total=1.8473525295233966,
)
def block_thrown_up_a_slope():
    angle = math.radians(25.0)
    up, back = 4.0, slide(np.array([1.0]), angle, 0.3, 0.0)[1][0]
    time = slide(np.array([0.0]), angle, 0.3, -up)[2]
    way = -slide(np.array([time]), angle, 0.3, -up)[0][0]
    total = time + math.sqrt(2.0 * way / back)
    speed = slide(np.array([total]), angle, 0.3, -up)[1][0]
    return {"mu_threshold": math.tan(angle), "a_down": back, "a_up": up / time, "up_distance": way, "up_time": time,
            "return_speed": speed, "return_time_total": total}  # fmt: skip


@entry(
    "D01-stops",
    a_down=-1.1886424868214602,
    stop_distance_from_v0_down=3.7858313579497024,
    stop_time_from_v0_down=2.5238875719664683,
)
def block_thrown_down_a_slope():
    angle, speed = math.radians(25.0), 3.0
    way, _, time = slide(np.array([10.0]), angle, 0.6, speed)
    return {"a_down": -speed / time, "stop_distance_from_v0_down": way[0], "stop_time_from_v0_down": time}


@entry("D02", time=1.4562399883500801, distance=3.6405999708752002, x=2.1843599825251201, y=2.9124799767001602)
def sliding_block():
    scenario = families()["sliding-block"].of(heading=math.degrees(math.atan2(4.0, 3.0)))
    x, y, _ = scenario.truth(np.array([10.0])).x[0, 1]
    return {"time": scenario.events[0], "distance": math.hypot(x, y), "x": x, "y": y}


def across_a_slope(ratio: float) -> Numbers:
    path = along_the_path(np.array(math.tan(math.radians(15.0))), 2.0, ratio)
    return {"speed_at_phi": path.speed, "time_at_phi": path.time, "across_at_phi": path.across,
            "down_at_phi": path.down}  # fmt: skip


@entry(
    "D03",
    speed_at_phi=1.0717967697244908,
    time_at_phi=0.53083278678092427,
    across_at_phi=0.63123864763846249,
    down_at_phi=0.31838369858406001,
)
def sideways_launch():
    return across_a_slope(1.0)


@entry(
    "D03-r0.8",
    speed_at_phi=1.3947679307932668,
    time_at_phi=0.59916531509502103,
    across_at_phi=0.76446658698848063,
    down_at_phi=0.43464746154983897,
)
def sideways_launch_with_less_friction():
    return across_a_slope(0.8)


@entry("D03-limit", terminal_speed_if_r1=1.0)
def sideways_launch_in_the_end():
    return {"terminal_speed_if_r1": along_the_path(np.array(1e-20), 2.0, 1.0).speed}


def bowling(backspin: float) -> Numbers:
    scenario = families()["sliding-to-rolling"].of(speed=8.0, mu=0.12, backspin=backspin)
    truth = scenario.truth(np.array([0.0, scenario.events[0]]))
    v, w, radius = truth.v[:, 1, 0], truth.w[:, 1, 1], scenario.scene.bodies[1].shape.radius
    energy = v**2 + 0.4 * (radius * w) ** 2
    return {"time": scenario.events[0], "v_roll": v[1], "w_roll": -w[1], "distance": truth.x[1, 1, 0],
            "energy_ratio": energy[1] / energy[0]}  # fmt: skip


@entry(
    "D04",
    time=1.9416533178001068,
    v_roll=5.7142857142857143,
    w_roll=-52.91005291005291,
    distance=13.314194179200732,
    energy_ratio=0.71428571428571429,
)
def sliding_to_rolling():
    return bowling(0.0)


@entry(
    "D04-backspin",
    time=3.2522693073151789,
    v_roll=4.1714285714285714,
    w_roll=-38.624338624338624,
    distance=19.792381784518089,
    energy_ratio=0.32196477660634988,
)
def backspin_to_rolling():
    return bowling(50.0)


@entry("D05", v_final=2.1428571428571429, w_final=-21.428571428571429)
def bouncing_to_rolling():
    truth = at("bouncing-to-rolling", 2.4)
    return {"v_final": truth.v[0, 1, 0], "w_final": -truth.w[0, 1, 1]}


@entry(
    "D06",
    sphere_mu_min=0.1649572197684645,
    sphere_acc=3.5035714285714286,
    sphere_time=1.0684999536108847,
    sphere_speed=3.7435659089009925,
    cylinder_mu_min=0.19245008972987525,
    cylinder_acc=3.27,
    cylinder_time=1.106002527218662,
    cylinder_speed=3.6166282640050249,
    hoop_mu_min=0.28867513459481288,
    hoop_acc=2.4525,
    hoop_time=1.2771017136282019,
    hoop_speed=3.1320919526731651,
    shell_mu_min=0.23094010767585031,
    shell_acc=2.943,
    shell_time=1.165829027971115,
    shell_speed=3.4310348293189913,
    slip_acc=4.0554290788874657,
    slip_sphere_R_alpha=2.1239273027813358,
)
def rolling_down():
    slope, said = math.radians(30.0), {}
    for name, body in (("sphere", "ball"), ("cylinder", "cylinder"), ("hoop", "hoop"), ("shell", "shell")):
        pace, _ = accelerations(slope, 1.0, RATIOS[body])
        said |= {f"{name}_mu_min": needed_friction(slope, RATIOS[body]), f"{name}_acc": pace,
                 f"{name}_time": math.sqrt(4.0 / pace), f"{name}_speed": math.sqrt(4.0 * pace)}  # fmt: skip
    pace, roll = accelerations(slope, 0.1, RATIOS["ball"])
    return said | {"slip_acc": pace, "slip_sphere_R_alpha": roll}


@entry(
    "D07",
    v_common=0.85714285714285714,
    time=0.87374399301004806,
    slide=1.3106159895150721,
    energy_lost=6.4285714285714286,
)
def block_on_plank():
    speed, time, way = together(3.0, 0.25)
    return {"v_common": speed, "time": time, "slide": way, "energy_lost": 0.5 * LIGHT * 9.0 - 0.5 * 7.0 * speed**2}


@entry("D08", f_per_ball=0.211, a_ball=0.211, a_slab=0.7385, mu_ball_min=0.021508664627930683, v_slab_4s=2.954)
def slab_with_balls():
    slab, ball = slab_accelerations(150.0, 25)
    return {"f_per_ball": ball, "a_ball": ball, "a_slab": slab, "mu_ball_min": ball / GRAVITY, "v_slab_4s": 4.0 * slab}


def off_the_sphere(ratio: float) -> Numbers:
    cosine = leaving_cosine(0.0, ratio)
    speed, place = flight_to_centre(cosine)
    return {"leave_cos": cosine, "leave_angle_deg": math.degrees(math.acos(cosine)), "leave_speed": speed,
            "landing_x_at_y0": place}  # fmt: skip


@entry(
    "D12",
    leave_cos=0.66666666666666667,
    leave_angle_deg=48.189685104221402,
    leave_speed=2.5573423705088844,
    landing_x_at_y0=1.1245802215092528,
)
def sliding_off_the_sphere():
    return off_the_sphere(0.0)


@entry(
    "D12-rolls",
    leave_cos=0.58823529411764706,
    leave_angle_deg=53.968120927529442,
    leave_speed=2.4022048695509127,
    landing_x_at_y0=1.0925701005221264,
)
def rolling_off_the_sphere():
    return off_the_sphere(0.4)


@entry(
    "D15",
    a_threshold=2.943,
    conveyor_time=0.67957866123003738,
    conveyor_skid=0.67957866123003738,
    stick_time=2.0387359836901121,
    slip_distance=1.6162079510703364,
)
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


@entry(
    "E04",
    w_body0=-0.28729784409701539,
    w_body1=-0.086370994999519588,
    w_body2=2.0,
    q0=0.80109764815951246,
    q1=-0.0085591307126218272,
    q2=0.058199619153343202,
    q3=0.59563588183146593,
    kinetic_energy=3.645,
    L_norm=3.6124783736376886,
)
def free_symmetric_body():
    return tumbled((1.0, 1.0, 1.8), (0.3, 0.0, 2.0), 10.0)


@entry(
    "E05",
    w_body0=2.7558404051468494,
    w_body1=-3.7359635192162199,
    w_body2=-3.1618090034675183,
    q0=0.22516456341395816,
    q1=-0.61992756249945249,
    q2=-0.27702915068719459,
    q3=0.69874572364031014,
    w_world0=2.6678188014706755,
    w_world1=4.9388371655813563,
    w_world2=0.19936455139903461,
    kinetic_energy=8.5464166666666667,
    L_norm=3.4176520936650842,
)
def free_asymmetric_body():
    return tumbled((97 / 120, 41 / 60, 17 / 120), (0.1, 5.0, 0.1), 10.0)


@entry(
    "E14",
    landing_angle_rad=1.1902899496825317,
    w_landing=4.1424808336237722,
    time=1.1505232322060822,
    ratio_far_edge=-0.29310344827586207,
)
def toppling_box():
    lands = 0.5 * math.pi - toppling.LEAN
    start = math.radians(2.0)
    return {"landing_angle_rad": lands, "w_landing": fall_speed(toppling.RATE, start, lands),
            "time": fall_time(toppling.RATE, start, lands),
            "ratio_far_edge": 1.0 - 1.5 * math.cos(toppling.LEAN) ** 2}  # fmt: skip


@entry("F01", N_total=88.67, cop_x=0.13533325814818992, N_left_edge=38.335, N_right_edge=50.335)
def loaded_box():
    total, place = support(20.0, 0.6)
    left, right = (0.5 * total * (1.0 + side * place) for side in (-1.0, 1.0))
    return {"N_total": total, "cop_x": place, "N_left_edge": left, "N_right_edge": right}


@entry("F02", N1_on_side_a=34.112645760509448, N2_on_side_b=22.593112978344954)
def groove():
    one, other = groove_forces(4.0, math.radians(35.0), math.radians(60.0))
    return {"N1_on_side_a": one, "N2_on_side_b": other}


@entry(
    "F03",
    N_interface_0=147.15,
    N_interface_1=98.1,
    N_interface_2=58.86,
    N_interface_3=29.43,
    N_interface_4=9.81,
    overhang_1=0.5,
    overhang_2=0.75,
    overhang_3=0.91666666666666667,
    overhang_4=1.0416666666666667,
    overhang_5=1.1416666666666667,
)
def stack():
    loads = {f"N_interface_{k}": force for k, force in enumerate(interfaces([5.0, 4.0, 3.0, 2.0, 1.0]))}
    return loads | numbered("overhang", [overhang(n) for n in range(1, 6)])


@entry("F05", tip_angle_deg=21.801409486351812, slide_angle_deg=16.699244233993622, mu_equal=0.4)
def tip_or_slide():
    tips, slides = (math.degrees(a) for a in thresholds(0.3))
    return {"tip_angle_deg": tips, "slide_angle_deg": slides, "mu_equal": math.tan(math.radians(tips))}


@entry("F07", mu_balls_between=0.31783724519578224, mu_balls_floor=0.079459311298945561)
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


@entry(
    "G01",
    vn_before=-3.649519052838329,
    j=3.5933726058715855,
    vx_after=0.4,
    vy_after=-1.2033136970642073,
    w_after=-7.8358558858436409,
    vn_after=2.1897114317029974,
    energy_loss=2.6228163578151333,
)
def rod_on_smooth_floor():
    return corner_impact_of_a_rod(0.6, 1.0 / 12.0, grips=False)


@entry(
    "G01-dumbbell",
    vn_before=-3.649519052838329,
    j=6.6734062680472301,
    vx_after=0.4,
    vy_after=0.33670313402361507,
    w_after=-4.2793393579032063,
    vn_after=2.1897114317029974,
    energy_loss=4.870944664513819,
)
def dumbbell_on_smooth_floor():
    return corner_impact_of_a_rod(0.6, 0.25, grips=False)


@entry(
    "G02",
    w_after=-3.8221143170299739,
    vx_after=0.95552857925749348,
    vy_after=-1.6550240473580836,
    p_t=1.111057158514987,
    p_n=2.6899519052838329,
    mu_min=0.41303978570492422,
    energy_loss=4.4779807158514987,
)
def rod_that_sticks():
    return corner_impact_of_a_rod(0.0, 1.0 / 12.0, grips=True)


@entry("G03", J=2.448, v_rod=0.816, w_rod=-2.72, vb_after=-0.896, instant_centre_below_com=0.3, energy_loss=1.4688)
def struck_rod():
    after = struck(0.7, 0.4)
    left = 0.5 * ROD * after.rod**2 + 0.5 * MOMENT * after.spin**2 + 0.25 * after.ball**2
    return {"J": after.impulse, "v_rod": after.rod, "w_rod": -after.spin, "vb_after": after.ball,
            "instant_centre_below_com": after.rod / after.spin, "energy_loss": 4.0 - left}  # fmt: skip


@entry(
    "G04",
    corner_r0=-0.059535489037941736,
    corner_r1=-0.13236560216237862,
    corner_r2=-0.34486935629192111,
    K=0.58079935306593811,
    j=5.1652950096509667,
    v_after0=0.0,
    v_after1=0.0,
    v_after2=-0.2782349967830111,
    w_after0=-8.1603981458328431,
    w_after1=3.3270740784350307,
    w_after2=4.0041746509038648,
    vn_after=1.0,
    energy_loss=2.5826475048254833,
)
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


@entry(
    "G05",
    **{
        "L1_e1.0_v": 2,
        "L1_e1.0_w": 0,
        "L2_e1.0_v": 1.9120700183187462,
        "L2_e1.0_w": 1.8172196214125789,
        "L2_e1.0_impacts": 3,
        "L1_e0.5_v": 1,
        "L1_e0.5_w": 0,
        "L2_e0.5_v": 0.75010177081213108,
        "L2_e0.5_w": 0.50193364543049054,
        "L2_e0.5_impacts": 3,
        "L1_e0.0_v": 0,
        "L1_e0.0_w": 0,
    },
)
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


@entry(
    "G06",
    alpha=0.19739555984988076,
    p=3.7985845578046423,
    impact_time=0.35111985428517602,
    impact_time_linear=0.35072562127396733,
    w_before=0.65088111471735049,
    ratio=0.94230769230769231,
    w_after=0.61333028117596489,
    next_amplitude=0.084338023614295038,
)
def rocking_block():
    first, second = halves(0.1, 2)
    speed = fall_speed(rocking.RATE, rocking.LEAN - 0.1, rocking.LEAN)
    linear = math.acosh(1.0 / (1.0 - 0.1 / rocking.LEAN)) / rocking.RATE
    return {"alpha": rocking.LEAN, "p": rocking.RATE, "impact_time": first.impact, "impact_time_linear": linear,
            "w_before": speed, "ratio": rocking.KEPT, "w_after": rocking.KEPT * speed,
            "next_amplitude": second.tilt}  # fmt: skip


@pytest.mark.parametrize(("compute", "printed", "quantity", "digits"), rows())
def test_the_truth_has_the_printed_number(compute, printed, quantity, digits):
    assert float(compute()[quantity]) == pytest.approx(float(printed[quantity]), rel=digits, abs=digits)
