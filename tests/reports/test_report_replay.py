"""Replay blocks: what comes out of them is what was recorded, within half a quantum."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from mechanics.effects import Gravity, Hinge, Rod, Tether
from mechanics.rotation import rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from reports.motion import motion
from reports.packing import MISSING, packed, quantised, unpacked
from reports.recorded import recorded
from reports.replay import FRAMES, Replay, frames, moment, replay
from reports.series import time_series

shapes = array_shapes(min_dims=2, max_dims=2, max_side=30)
whole = st.one_of(arrays(np.int16, shapes), arrays(np.int32, shapes))


@given(st.lists(whole, max_size=4))
def test_what_is_packed_comes_out_as_it_was(given_arrays):
    header, found = unpacked(packed({"name": "x"}, given_arrays))
    assert header["name"] == "x"
    assert len(found) == len(given_arrays)
    for a, b in zip(found, given_arrays, strict=True):
        assert a.dtype == b.dtype
        assert np.array_equal(a, b)


def test_a_block_of_another_version_is_refused(monkeypatch):
    monkeypatch.setattr("reports.packing.VERSION", 2)
    block = packed({}, [])
    monkeypatch.undo()
    with pytest.raises(ValueError, match="version 2"):
        unpacked(block)


def test_blocks_are_the_same_every_time():
    assert packed({"a": 1}, [np.eye(3, dtype=np.int16)]) == packed({"a": 1}, [np.eye(3, dtype=np.int16)])


@given(arrays(np.float64, (20, 3), elements=st.floats(-5.0, 5.0)), st.floats(1e-3, 1.0))
def test_quantising_errs_by_half_a_quantum_at_most(values, quantum):
    steps = quantised(values, 1.0, quantum)
    assert np.abs(1.0 + steps * quantum - values).max() <= 0.5 * quantum * (1.0 + 1e-9)


def test_what_is_too_far_is_clipped_and_what_is_not_there_is_missing():
    assert quantised(np.array([[1e9, -1e9, np.nan]]), 0.0, 1.0).tolist() == [[32767, -32767, MISSING]]


def test_short_recordings_are_kept_whole():
    assert frames(np.random.default_rng(1).normal(size=(2 * FRAMES, 1, 3)), 0.0).tolist() == list(range(2 * FRAMES))


@given(st.integers(500, 5000), st.floats(0.02, 0.98))
def test_a_kink_of_a_long_recording_is_kept(count, part):
    turn = round(part * (count - 1))
    x = np.zeros((count, 2, 3))
    x[:, 1, 2] = np.abs(np.arange(count) - turn)
    kept = frames(x, 1e-3)
    assert turn in kept
    assert len(kept) <= FRAMES + 1
    drawn = np.interp(np.arange(count), kept, x[kept, 1, 2])
    assert np.abs(drawn - x[:, 1, 2]).max() < 1e-9


def test_a_fast_spin_is_not_seen_turning_the_other_way(tumbling):
    t = np.linspace(0.0, 2.0, 4001)
    path = _tumble(80.0 * t)  # 400 rad/s: 6.7 rad between two of 120 samples
    spun = replace(tumbling, motions={"reference": tumbling.motions["reference"]._replace(path=replace(path, t=t))})
    header, (ticks, _, q) = unpacked(replay(spun, time_series(spun)).block)
    assert len(ticks[0]) < 4001
    cosines = (q[:, 1:].astype(float) * q[:, :-1]).sum(axis=0) * header["turn"] ** 2
    assert 2.0 * np.arccos(np.clip(cosines, -1.0, 1.0)).sum() == pytest.approx(800.0, rel=1e-2)


def _tumble(t: np.ndarray) -> Trajectory:
    """A floor, a ball on a circle of 1 m about the origin and a box that turns about a tilted axis, 5 rad/s."""
    angle, axis = 5.0 * t, np.array([0.6, 0.0, 0.8])
    x, q = np.zeros((len(t), 3, 3)), np.zeros((len(t), 3, 4))
    x[:, 1] = np.stack([np.cos(angle), 0.0 * t, np.sin(angle)], axis=1)
    x[:, 2, 0] = -1.5
    q[:, :2, 0] = 1.0
    q[:, 2] = np.concatenate([np.cos(angle / 2)[:, None], np.sin(angle / 2)[:, None] * axis], axis=1)
    q[1::2, 2] *= -1.0  # as an engine may, and it is the same orientation
    return Trajectory(t, x, q, np.zeros_like(x), np.zeros_like(x))


@pytest.fixture
def tumbling(campaign, falling):
    """One scenario in two engines; the second stops half-way."""
    bodies = (Body("floor", HalfSpace()), Body("ball", Sphere(0.1), mass=1.0, position=(1.0, 0.0, 0.0)),
              Body("box", Box((0.2, 0.3, 0.4)), mass=1.0, position=(-1.5, 0.0, 0.0)))  # fmt: skip
    scene = Scene(bodies, (Gravity(), Rod("ball", "box"), Tether("floor", "ball", 2.0)))
    known = replace(falling, scene=scene, truth=_tumble)
    whole = _tumble(np.linspace(0.0, 2.0, 201))
    cells = {c.engine: c for c in campaign.cells if c.scenario == "free-fall"}
    kept = replace(campaign, cells=(cells["reference"], cells["mujoco"]))
    traces = {cells["reference"].key: whole, cells["mujoco"].key: whole.until(101)}
    return recorded(kept, traces, {"free-fall": known})[0]


def test_poses_in_a_block_are_the_recorded_ones_within_half_a_quantum(tumbling):
    made = replay(tumbling, time_series(tumbling))
    header, found = unpacked(made.block)
    assert [e["name"] for e in header["engines"]] == ["reference", "mujoco"]
    assert header["animated"] == [1, 2]
    assert header["turning"] == [2]
    for k, motion_ in enumerate(tumbling.motions.values()):
        ticks, x, q = found[3 * k : 3 * k + 3]
        path = motion_.path
        assert np.abs(ticks[0] * header["tick"] - path.t).max() <= 0.5 * header["tick"]
        places = np.array(header["centre"]) + header["quantum"] * x.T.reshape(-1, 2, 3)
        assert np.abs(places - path.x[:, 1:]).max() <= 0.5 * header["quantum"] * (1 + 1e-9)
        turns = header["turn"] * q.T
        assert np.abs(np.diff(turns, axis=0)).max() < 0.05  # no sign jumps
        same = np.minimum(np.abs(turns - path.q[:, 2]).max(axis=1), np.abs(turns + path.q[:, 2]).max(axis=1))
        assert same.max() <= 0.5 * header["turn"] * (1 + 1e-9)


def test_the_quantum_is_far_below_a_pixel(tumbling):
    header, _ = unpacked(replay(tumbling, time_series(tumbling)).block)
    assert header["quantum"] == pytest.approx(max(header["size"]) / 2**14)
    assert max(header["size"]) < 5.0


def test_one_engine_that_flies_away_does_not_spoil_the_picture_of_the_others(tumbling):
    path = tumbling.motions["mujoco"].path
    away = Trajectory(path.t, path.x + 1e6 * path.t[:, None, None], path.q, path.v, path.w)
    spoiled = replace(tumbling, motions=tumbling.motions | {"mujoco": tumbling.motions["mujoco"]._replace(path=away)})
    calm, wild = (unpacked(replay(one, time_series(one)).block)[0] for one in (tumbling, spoiled))
    assert max(wild["size"]) <= 2.0 * max(calm["size"])


def test_rods_end_where_they_are_fastened_and_arms_of_hinges_meet(falling, tumbling):
    header, _ = unpacked(replay(tumbling, time_series(tumbling)).block)
    assert [(e["kind"], e["a"], e["b"]) for e in header["links"]] == [("Rod", 1, 2), ("Tether", 0, 1)]
    turned = (math.cos(0.4), 0.0, math.sin(0.4), 0.0)
    bodies = (Body("a", Sphere(0.1), mass=1.0, position=(1.0, 0.0, 0.0), orientation=turned),
              Body("b", Sphere(0.1), mass=1.0, position=(3.0, 0.0, 1.0)))  # fmt: skip
    scene = Scene(bodies, (Hinge("a", "b", point=(2.0, 0.0, 0.5)),))
    x, q = np.array([[b.position for b in bodies]] * 2), np.array([[b.orientation for b in bodies]] * 2)
    x[1] += 1.0
    path = Trajectory(np.array([0.0, 1.0]), x, q, np.zeros_like(x), np.zeros_like(x))
    motion_ = tumbling.motions["reference"]._replace(path=path)
    hinged = replace(tumbling, scene=scene, motions={"reference": motion_}, truth=None)
    links = unpacked(replay(hinged, time_series(hinged)).block)[0]["links"]
    ends = [
        np.array(bodies[e["b"]].position) + rotate(np.array(bodies[e["b"]].orientation), np.array(e["q"]))
        for e in links
    ]
    assert np.allclose(ends, (2.0, 0.0, 0.5))


def test_nothing_to_show_makes_no_replay(tumbling):
    still = {e: m._replace(path=m.path.until(1)) for e, m in tumbling.motions.items()}
    assert replay(replace(tumbling, motions=still), time_series(tumbling)) is None
    assert replay(replace(tumbling, scene=None), time_series(tumbling)) is None


def test_a_scene_that_cannot_be_read_costs_the_replay_and_is_told(campaign):
    cell = next(c for c in campaign.cells if (c.scenario, c.engine) == ("free-fall", "reference"))
    told = {
        "free-fall": campaign.scenarios["free-fall"] | {"scene": {"body": [{"name": "x", "shape": {"type": "Cone"}}]}}
    }
    one = recorded(replace(campaign, cells=(cell,), scenarios=told), {cell.key: _tumble(np.linspace(0.0, 1.0, 5))}, {})[
        0
    ]
    assert one.scene is None
    assert "Cone" in one.remark
    assert replay(one, time_series(one)) is None


def test_a_link_leads_to_the_moment(tumbling):
    made = replay(tumbling, time_series(tumbling))
    cell = tumbling.cells["mujoco"]
    assert made.link(cell.key) == "#scene=free-fall&t=0.800"
    assert made.link("another") == ""
    assert moment(replace(cell, state="diverged", time=1.25)) == 1.25
    assert Replay("a[e=0.3]", "", {"k": math.nan}, False).link("k") == "#scene=a%5Be%3D0.3%5D"


def test_beyond_the_budget_what_passes_goes_first(campaign, traces, falling):
    path = next(iter(traces.values()))
    known = {s: replace(falling, name=s) for s in dict.fromkeys(c.scenario for c in campaign.cells)}
    all_of_them = motion(campaign, {c.key: path for c in campaign.cells}, known)
    assert len(all_of_them.replays) == 9
    size = len(all_of_them.replays[0].block)
    few = motion(campaign, {c.key: path for c in campaign.cells}, known, budget=round(3.5 * size))
    assert 0 < len(few.replays) < 9
    assert "free-fall" not in {r.scenario for r in few.replays}  # nobody fails it
    assert few.recorded == 9
