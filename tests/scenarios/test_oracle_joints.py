"""Truths of jointed bodies against numbers computed elsewhere with 40 digits; see `conftest`.

Each function says what the project's own truth gives for the quantities of one entry of the catalogue.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from scenarios.catalogue import families
from scenarios.double_pendulum import angles
from scenarios.pendulum import ARMS, RATES
from scenarios.swing import fall_speed, fall_time, quarter, swing
from scenarios.tethered_ball import taut
from scenarios.tolerance import GRAVITY

Numbers = Mapping[str, float]


def at(scenario: str, time: float, **parameters: object):
    """Truth of a scenario at a time [s]."""
    return families()[scenario].of(**parameters).truth(np.array([time]))


def tethered_ball(e: float) -> Numbers:
    jerk = taut(e)
    later = at("tethered-ball", 3.0, e=e).x[0, 1]
    return {"taut_time": jerk.time, "taut_x": jerk.place[0], "taut_y": jerk.place[1], "impulse": jerk.impulse,
            "vx_after": jerk.velocity[0], "vy_after": jerk.velocity[1], "x(t)": later[0], "y(t)": later[2]}  # fmt: skip


def pendulum(kind: str, degrees: float) -> Numbers:
    amplitude, rate = math.radians(degrees), RATES[kind]
    lowest = 2.0 * rate * math.sin(0.5 * amplitude)
    turn, speed = swing(np.array([10.0]), rate, amplitude)
    return {"period": 4.0 * quarter(rate, amplitude), "period_small": 2.0 * math.pi / rate, "rate_bottom": lowest,
            "pivot_force_bottom_over_mg": 1.0 + lowest**2 * ARMS[kind] / GRAVITY, "theta(t)": turn[0],
            "theta_dot(t)": speed[0]}  # fmt: skip


def double_pendulum(time: float) -> Numbers:
    turn, rate = angles(np.array([time]))
    return {"theta1": turn[0, 0], "theta2": turn[1, 0], "rate1": rate[0, 0], "rate2": rate[1, 0]}


def hinged_falling_rod() -> Numbers:
    start, end = math.radians(5.0), 0.5 * math.pi
    return {
        "w_horizontal": fall_speed(RATES["rod"], start, end),
        "time_to_horizontal": fall_time(RATES["rod"], start, end),
    }


def dumbbell() -> Numbers:
    (x1, _, y1), (x2, _, y2) = at("dumbbell", 7.3).x[0]
    return {"x1": x1, "y1": y1, "x2": x2, "y2": y2}


ENTRIES: dict[str, Callable[[], Numbers]] = {
    "C12": partial(tethered_ball, 0.0),
    "C12-e0.5": partial(tethered_ball, 0.5),
    "E01": partial(pendulum, "rod", 120.0),
    "E01-bob": partial(pendulum, "bob", 120.0),
    "E01-10s": partial(pendulum, "bob", 90.0),
    "E03": partial(double_pendulum, 2.0),
    "E03-1s": partial(double_pendulum, 1.0),
    "E12": hinged_falling_rod,
    "E13": dumbbell,
}


def test_the_truth_has_the_printed_number(compute, quantity, printed):
    assert float(compute()[quantity]) == printed
