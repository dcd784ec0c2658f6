"""What is written is what is read, to the bit; what is no run is refused with its name."""

import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from adapters import archive
from adapters.engine import ContactForce, Impact, Refusal
from adapters.run import STAGES, Failure, Run, Timing
from mechanics.trajectory import Trajectory

numbers = st.floats(allow_nan=True, allow_infinity=True, width=64)
words = st.text(st.characters(blacklist_categories=("Cs",)), max_size=20)
triples = st.tuples(*[st.floats(-1e3, 1e3)] * 3)


@st.composite
def motions(draw):
    samples, bodies = draw(st.integers(1, 4)), draw(st.integers(1, 3))
    parts = [draw(arrays(np.float64, (samples, bodies, k), elements=numbers)) for k in (3, 4, 3, 3)]
    return Trajectory(np.arange(samples) * 0.1, *parts)


@st.composite
def timings(draw):
    repeats, intervals = draw(st.integers(1, 3)), draw(st.integers(1, 4))
    wall = draw(arrays(np.int64, (repeats, intervals), elements=st.integers(0, 10**12)))
    return Timing(wall, wall.sum(axis=1), tuple(draw(st.lists(words, min_size=repeats, max_size=repeats))))


outcomes = st.one_of(
    motions(),
    st.builds(Refusal, words),
    st.builds(Failure, st.sampled_from(["crash", "timeout"]), st.sampled_from(STAGES), st.floats(0, 10), words),
)
times = st.floats(0, 9)
impacts = st.builds(Impact, times, words, words, triples, triples, times)
forces = st.builds(ContactForce, times, words, words, triples, triples, triples)
runs = st.builds(
    Run,
    engine=words,
    version=words,
    settings=st.dictionaries(words, st.one_of(st.floats(1e-9, 1e9), words), max_size=3),
    outcome=outcomes,
    partial=st.none() | motions(),
    events=st.lists(impacts, max_size=2).map(tuple),
    knows_events=st.booleans(),
    contacts=st.lists(forces, max_size=2).map(tuple),
    timing=st.none() | timings(),
    build_seconds=st.floats(0, 10),
    notes=st.lists(words, max_size=2).map(tuple),
    lead=st.floats(-1, 1),
    audit=st.dictionaries(words, numbers, max_size=2),
    output=words,
)


def same(a, b):
    """Equality of archived things, bit by bit in arrays."""
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b, equal_nan=True) and a.dtype == b.dtype
    if isinstance(a, Refusal):
        return isinstance(b, Refusal) and a.reason == b.reason
    if isinstance(a, (Trajectory, Timing, Failure)):
        return type(a) is type(b) and all(same(v, vars(b)[k]) for k, v in vars(a).items())
    return repr(a) == repr(b)


@given(runs)
def test_what_is_written_is_read(tmp_path_factory, run):
    if isinstance(run.outcome, Trajectory):
        run = replace(run, partial=None)
    path = archive.write(tmp_path_factory.mktemp("runs") / "run.npz", run)
    back = archive.read(path)
    for name, value in vars(run).items():
        assert same(value, getattr(back, name)), name


def test_numbers_of_numpy_are_archived(tmp_path):
    run = Run("e", "1", {"dt": np.float64(0.1)}, Refusal("no"), audit={"n": np.int64(3), "r": np.array([1.0, 2.0])})
    back = archive.read(archive.write(tmp_path / "run.npz", run))
    assert back.audit == {"n": 3, "r": [1.0, 2.0]}


@pytest.fixture
def whole(tmp_path):
    motion = Trajectory(np.zeros(1), np.zeros((1, 1, 3)), np.ones((1, 1, 4)), np.zeros((1, 1, 3)), np.zeros((1, 1, 3)))
    return archive.write(tmp_path / "whole.npz", Run("e", "1", {}, motion))


@pytest.mark.parametrize("damage", ["text", "empty", "half", "foreign", "newer", "headless"])
def test_a_file_that_is_no_run_is_refused_by_name(whole, tmp_path, damage):
    path = tmp_path / f"{damage}.npz"
    data = whole.read_bytes()
    if damage == "text":
        path.write_text("not an archive")
    elif damage == "empty":
        path.write_bytes(b"")
    elif damage == "half":
        path.write_bytes(data[: len(data) // 2])
    elif damage == "foreign":
        np.savez(path, a=np.arange(3))
    elif damage == "newer":
        np.savez(path, header=np.array('{"schema": 99}'))
    else:
        np.savez(path, header=np.array('{"schema": 1}'))
    with pytest.raises(archive.ArchiveError, match=damage):
        archive.read(path)


def test_a_missing_file_is_an_os_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        archive.read(tmp_path / "nothing.npz")


def test_a_failed_write_leaves_nothing_behind(tmp_path, whole):
    with pytest.raises(TypeError, match="cannot be archived"):
        archive.write(whole, Run("e", "1", {}, Refusal("no"), audit={"x": object()}))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["whole.npz"]
    assert archive.read(whole).engine == "e"


def test_nothing_in_an_archive_is_pickled(whole):
    with zipfile.ZipFile(whole) as z:
        for name in z.namelist():
            assert np.lib.format.read_magic(z.open(name)) >= (1, 0)
            assert b"|O" not in z.read(name)[:128]
