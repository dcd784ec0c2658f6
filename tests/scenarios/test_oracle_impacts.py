"""Truths of free flight and of impacts against numbers computed elsewhere with 40 digits; see `conftest`.

Each function says what the project's own truth gives for the quantities of one entry of the catalogue.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial
from itertools import product

import numpy as np
from scipy.optimize import brentq

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


def at(scenario: str, *times: float, **parameters: object):
    """Truth of a scenario at `times`."""
    return families()[scenario].of(**parameters).truth(np.array(times, dtype=np.float64))


def free_fall():
    ground = math.sqrt(2.0 * 20.0 / GRAVITY)
    truth = at("free-fall", 1.5, ground)
    return {"y": truth.x[0, 0, 2], "v": truth.v[0, 0, 2], "t_ground": ground, "v_ground": truth.v[1, 0, 2],
            "y_ground": truth.x[1, 0, 2]}  # fmt: skip


def projectile():
    truth = at("projectile", 3.453297672163307, 1.6380927871726283)
    return {"range": truth.x[0, 0, 0], "apex_height": truth.x[1, 0, 2], "impact_vx": truth.v[0, 0, 0],
            "impact_vy": truth.v[0, 0, 2], "apex_vy": truth.v[1, 0, 2]}  # fmt: skip


def integrator_fingerprint():
    """The offset g t h/2 that the tolerance of free fall is made of, here at a step of 1/240 s."""
    check = families()["free-fall"].of().checks[0]
    offset = check.tolerance / 1.5 / 1.5 * 1000.0 / 240.0  # from 1.5 s, safety 1.5 and a step of 1 ms
    fall = at("free-fall", 1.0).x[0, 0, 2] - 20.0
    return {"exact": fall, "offset": offset, "semi_implicit_euler": fall - offset, "explicit_euler": fall + offset}


def bouncing_ball():
    e, times = 0.8, impact_times(1.0, 0.8, math.inf)
    apex = times[:5] + e ** np.arange(1, 6) * math.sqrt(2.0 / GRAVITY)
    heights = bounce(apex, 1.0, e)[0]
    said = {f"impact_time_{k + 1}": times[k] for k in range(5)} | {f"apex_height_{k + 1}": heights[k] for k in range(5)}
    # each impact at speed v changes the velocity by (1 + e) v
    changes = (1.0 + e) * math.sqrt(2.0 * GRAVITY) / (1.0 - e)
    return said | {"zeno_time": rest_time(1.0, e), "path_length": path_length(1.0, e), "velocity_sum": changes}


def bouncing_down_a_slope():
    _, places = impacts_down(math.radians(20.0), 1.0)
    return {f"distance_{k}": places[k] for k in range(1, 6)}


def bouncing_down_a_slope_with_losses():
    slope, e = math.radians(20.0), 0.7
    times, places = impacts_down(slope, e)
    last = times[0] * (1.0 + e) / (1.0 - e)  # where the impacts accumulate
    return {f"distance_{k}": places[k] for k in range(1, 6)} | {
        "sliding_starts_at_distance": 0.5 * GRAVITY * math.sin(slope) * (last**2 - times[0] ** 2),
        "sliding_starts_after_first_impact": last - times[0],
    }


def converging_walls():
    columns = zip(("position", "time", "speed_after"), hits(5), strict=True)
    return {f"hit_{k + 1}_{what}": column[k] for what, column in columns for k in range(5)}


def rectangle_billiard():
    t = 97.3
    sides = [(WIDTH, START[0], VELOCITY[0]), (HEIGHT, START[1], VELOCITY[1])]
    (x, u), (y, w) = (back_and_forth(np.array(t), *side) for side in sides)
    counts = [len(turns(*side, t)) for side in sides]
    return {"x": x, "y": y, "vx": u, "vy": w, "hits_x_walls": counts[0], "hits_y_walls": counts[1]}


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


def head_on_light():
    return head_on(1.0, 1e6, 2.0, -0.5)


def head_on_heavy():
    return head_on(1e6, 1.0, 2.0, -0.5)


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


def rough_bounce_that_slips():
    return rough_bounce(0.1)


def rough_bounce_that_sticks():
    return rough_bounce(0.6)


def rough_pair(mu: float) -> Numbers:
    along, across, spins = after_contact(0.7, mu)
    slip = across[0] - across[1] - 0.2 * spins[0] - 0.3 * spins[1]
    return {"Jn": 4.0 - along[0], "Jt": across[0], "v1x": along[0], "v1y": across[0], "w1_after": -spins[0],
            "v2x": along[1], "v2y": across[1], "w2_after": -spins[1], "slip_after": slip}  # fmt: skip


def rough_pair_that_slips():
    return rough_pair(0.15)


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


CRADLES = ((2, 1), (3, 1), (4, 1), (5, 1), (5, 2))  # balls, and how many of them come in


def cradle():
    said = {}
    for law, (count, moving) in product(("L1", "L2"), CRADLES):
        after = row_after(count, moving, law)
        said |= {f"{law}_n{count}_k{moving}_ball{k}": v for k, v in enumerate(after)}
    return said


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


def elastic_chain():
    return chain(Fraction(1))


def chain_with_losses():
    return chain(Fraction(1, 2))


def galperin(d: int) -> Numbers:
    root = 10.0**d
    wedge, start = math.atan(1.0 / root), (2.0 * root, 1.0)
    count = len(reflections(wedge, start, root))
    scaled, light = in_wedge(np.array([1e6]), wedge, start, root).v[0]
    return {"collisions": count, "block_block_hits": (count + 1) // 2, "V_heavy": scaled / root, "v_light": light}


def sticking_train():
    times = couplings(6)
    truth = at("sticking-train", *times)
    return numbered("t", times) | numbered("v_train", truth.v[:, 0, 0])


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


def symmetric_break():
    return three_ball_break(1.0)


def symmetric_break_with_losses():
    return three_ball_break(0.5)


def stacked_drop():
    shot = launched(0.0)
    return {"v_top": shot.small, "v_big": shot.big, "rise_top": shot.small**2 / (2.0 * GRAVITY)}


def times_of_a_projectile():
    """When the height of the truth is zero, and when its rise ends."""

    def height(t: float) -> float:
        return at("projectile", t).x[0, 0, 2]

    apex = brentq(lambda t: at("projectile", t).v[0, 0, 2], 1.0, 3.0, xtol=1e-15)
    return {"flight_time": brentq(height, 3.0, 4.0, xtol=1e-15), "apex_time": apex}


def least_grip_of_a_rough_pair():
    grips = rough_pair(1.0)
    return {"mu_critical": -grips["Jt"] / grips["Jn"]}


def end_of_a_chain():
    said = chain(Fraction(1))
    return {"last_impact_time": said[f"time_{said['hits']}"]}


def energy_of_a_train():
    v = at("sticking-train", 0.0, couplings(6)[-1]).v[:, :, 0]
    energy = (v**2).sum(axis=1)
    return {"energy_ratio_final": energy[1] / energy[0]}


def impacts_of_a_break():
    balls = families()["symmetric-break"].of().scene
    j, inverse = smooth_contacts(balls, PAIRS)
    w, v = (j * inverse) @ j.T, np.array([b.velocity for b in balls.bodies]).ravel()
    return {"L2_impacts": sequential(w, j @ v, 1.0, range(len(PAIRS)))[1]}


def limit_of_the_cannon():
    """A ball without mass on one that returns as it came: three times the speed, nine times the height."""
    _, top = after_collision(1.0, 0.0, 1.0, -1.0, 1.0)
    return {"ratio_limit_elastic": top**2}


ENTRIES: dict[str, Callable[[], Numbers]] = {
    "A01": free_fall,
    "A02": projectile,
    "A03": integrator_fingerprint,
    "B01": bouncing_ball,
    "B02": bouncing_down_a_slope,
    "B02-e0.7": bouncing_down_a_slope_with_losses,
    "B03": converging_walls,
    "B04": rectangle_billiard,
    "B05": wedge_billiard,
    "C01": head_on_light,
    "C01-swap": head_on_heavy,
    "C02": oblique_collision,
    "C03": rough_bounce_that_slips,
    "C03-sticks": rough_bounce_that_sticks,
    "C04": rough_pair_that_slips,
    "C04-sticks": rough_pair_that_sticks,
    "C05": cradle,
    "C05-e0.9": cradle_with_losses,
    "C06": elastic_chain,
    "C06-e0.5": chain_with_losses,
    "C08": sticking_train,
    "C09": inelastic_collapse,
    "C10": symmetric_break,
    "C10-e0.5": symmetric_break_with_losses,
    "C11": stacked_drop,
    "A02-times": times_of_a_projectile,
    "C04-critical": least_grip_of_a_rough_pair,
    "C06-last": end_of_a_chain,
    "C08-energy": energy_of_a_train,
    "C10-count": impacts_of_a_break,
    "C11-limit": limit_of_the_cannon,
}
ENTRIES |= {f"C07-d{d}": partial(galperin, d) for d in range(5)}


def test_the_truth_has_the_printed_number(compute, quantity, printed):
    assert float(compute()[quantity]) == printed
