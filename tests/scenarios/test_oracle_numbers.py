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

from mechanics.scene import Scene
from scenarios.bouncing_ball import bounce, impact_times
from scenarios.bouncing_to_rest import path_length, rest_time
from scenarios.catalogue import families
from scenarios.converging_walls import hits
from scenarios.gapped_chain import MASSES, PLACES, SPEEDS
from scenarios.head_on_collision import after_collision
from scenarios.impact_laws import sequential, simultaneous, smooth_contacts
from scenarios.incline_bounce import impacts_down
from scenarios.inelastic_collapse import CRITICAL, history
from scenarios.on_a_line import balls_on_a_line, impacts_in_turn
from scenarios.rectangle_billiard import HEIGHT, START, VELOCITY, WIDTH, back_and_forth, turns
from scenarios.rough_bounce import MASS, RADIUS, RATIO, after_bounce
from scenarios.rough_collision import after_contact
from scenarios.stacked_drop import launched
from scenarios.sticking_train import couplings
from scenarios.symmetric_break import PAIRS
from scenarios.tolerance import GRAVITY
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


@pytest.mark.parametrize(("compute", "printed", "quantity", "digits"), rows())
def test_the_truth_has_the_printed_number(compute, printed, quantity, digits):
    assert float(compute()[quantity]) == pytest.approx(float(printed[quantity]), rel=digits, abs=digits)
