"""Whatever an engine does, it costs its own cell only."""

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from adapters import registry
from adapters.run import Failure, run
from adapters.scratch import Scratch
from adapters.workers import Workers
from mechanics.effects import Gravity
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import State, Trajectory

SCENE = Scene((Body("a", Sphere(0.1), mass=1.0, velocity=(1.0, 0.0, 0.0)), Body("b", Sphere(0.1))), (Gravity(),))
TIMES = np.linspace(0.0, 1.0, 11)


@pytest.fixture(scope="module")
def workers(toys):
    """One pool for all tests of this file: each finds it usable, whatever the tests before did to it."""
    with Workers() as pool:
        yield pool


def faulty(workers, fault, timeout=30.0):
    return workers.run("toy:faulty", SCENE, TIMES, {"fault": fault}, timeout=timeout)


def test_a_worker_answers_what_the_engine_answers_here(workers, toys):
    here, there = run(toys["toy"], SCENE, TIMES), workers.run("toy", SCENE, TIMES)
    assert there.outcome.digest() == here.outcome.digest()
    assert (there.engine, there.version, there.settings) == (here.engine, here.version, here.settings)
    assert there.events == here.events
    assert there.audit == here.audit


@pytest.mark.parametrize(
    ("fault", "state", "reason"),
    [
        ("segv", "crash", "SIGSEGV"),
        ("abort", "crash", "SIGABRT"),
        ("exit", "crash", "exit code 3"),
        ("kill", "crash", "SIGKILL"),
        ("hang", "timeout", "killed after 0.5 s"),
        ("oom", "oom", "memory"),
        ("bad_alloc", "oom", "SIGABRT"),
        ("raise", "error", "ArithmeticError: the solver has met a singular matrix"),
        ("nan", "diverged", "NaN"),
    ],
)
def test_a_fault_costs_its_own_cell_and_keeps_what_was_computed(workers, toys, fault, state, reason):
    before = faulty(workers, "none")
    broken = faulty(workers, fault, timeout=0.5 if fault == "hang" else 30.0)
    assert isinstance(broken.outcome, Failure)
    assert (broken.outcome.state, broken.outcome.time) == (state, pytest.approx(0.5))
    assert broken.outcome.stage == ("read" if fault == "nan" else "advance")
    assert reason in broken.outcome.reason
    assert broken.settings["fault"] == fault
    whole = run(toys["toy"], SCENE, TIMES).outcome
    for name in ("t", "x", "q", "v", "w"):
        np.testing.assert_array_equal(getattr(broken.partial, name), getattr(whole.until(6), name))
    assert isinstance(before.outcome, Trajectory)
    assert before.outcome.digest() == whole.digest()


def test_a_crash_leaves_the_neighbour_alone(workers):
    workers.run("toy", SCENE, TIMES)
    neighbour = workers._workers["toy"]._process
    faulty(workers, "segv")
    assert neighbour.poll() is None
    assert isinstance(workers.run("toy", SCENE, TIMES).outcome, Trajectory)
    assert workers._workers["toy"]._process is neighbour


def test_what_a_dying_engine_said_is_kept(workers):
    assert "solver: assertion failed" in faulty(workers, "abort").output
    assert "Segmentation fault" in faulty(workers, "segv").output


def test_prints_are_returned_with_their_run_and_do_not_reach_ours(workers, capfd):
    said = faulty(workers, "print").output
    assert all(phrase in said for phrase in ("python speaks", "C speaks", "the descriptor speaks"))
    assert faulty(workers, "none").output == ""
    captured = capfd.readouterr()
    assert (captured.out, captured.err) == ("", "")


def test_a_run_that_cannot_be_sent_is_an_error_of_its_cell(workers):
    broken = faulty(workers, "unsendable")
    assert broken.outcome.state == "error"
    assert "cannot be sent" in broken.outcome.reason
    assert isinstance(faulty(workers, "none").outcome, Trajectory)


def test_the_limit_of_memory_is_that_of_the_worker(toys):
    with Workers(memory=1 << 50) as pool:
        assert faulty(pool, "oom").outcome.state == "oom"  # 8 TiB: nobody has them
        assert isinstance(faulty(pool, "none").outcome, Trajectory)


def test_threads_are_pinned_before_numpy_is_imported(tmp_path):
    engine = tmp_path / "counting.py"
    engine.write_text(
        "import os, sys\n"
        "SEEN = {n: os.environ.get(n) for n in ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS')}\n"
        "name, version, effects, knobs = 'counting', '1', {}, {}\n"
        "def vacuum(scene): raise RuntimeError(str(SEEN))\n"
        "start = advance = read = None\n"
    )
    registry.register("counting", str(engine))
    try:
        with Workers() as pool:
            said = pool.run("counting", Scene(SCENE.bodies), TIMES).outcome.reason
    finally:
        registry.unregister("counting")
    assert "'OMP_NUM_THREADS': '1', 'OPENBLAS_NUM_THREADS': '1'" in said


def test_an_engine_that_imports_here_and_not_there_fails_in_the_stage_import(tmp_path):
    engine = tmp_path / "homebody.py"
    engine.write_text(
        f"import os\nif os.getpid() != {os.getpid()}: raise OSError('no display')\n"
        "name, version, effects, knobs = 'homebody', '1', {}, {}\n"
        "vacuum = start = advance = read = lambda *a: None\n"
    )
    registry.register("homebody", str(engine))
    try:
        with Workers() as pool:
            failure = pool.run("homebody", Scene(SCENE.bodies), TIMES).outcome
    finally:
        registry.unregister("homebody")
    assert (failure.state, failure.stage) == ("error", "import")
    assert "no display" in failure.reason


def test_impossible_settings_are_the_callers_error(workers):
    with pytest.raises(ValueError, match="has no knob 'tempo'"):
        workers.run("toy", SCENE, TIMES, {"tempo": 1.0})
    with pytest.raises(ValueError, match="times"):
        workers.run("toy", SCENE, [0.0])


def test_a_script_needs_no_main_guard(tmp_path, toy_file):
    script = tmp_path / "script.py"
    script.write_text(
        "from adapters import registry\nfrom adapters.workers import Workers\n"
        "from mechanics.scene import Body, Scene\nfrom mechanics.shapes import Sphere\n"
        f"registry.register('toy', {str(toy_file)!r})\n"
        "with Workers() as workers:\n"
        "    run = workers.run('toy', Scene((Body('a', Sphere(0.1), mass=1.0),)), [0.0, 1.0])\n"
        "print(type(run.outcome).__name__)\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert (done.stdout, done.stderr) == ("Trajectory\n", "")


def test_a_worker_that_hangs_does_not_outlive_a_parent_that_is_killed(tmp_path, toy_file):
    script = tmp_path / "script.py"
    script.write_text(
        "import os, signal, threading, time\nfrom adapters import registry\nfrom adapters.workers import Workers\n"
        "from mechanics.scene import Body, Scene\nfrom mechanics.shapes import Sphere\n"
        f"registry.register('toy', {str(toy_file)!r})\n"
        "scene = Scene((Body('a', Sphere(0.1), mass=1.0),))\n"
        "workers = Workers()\n"
        "workers.run('toy:faulty', scene, [0.0, 0.1])\n"
        "print(workers._workers['toy:faulty']._process.pid, flush=True)\n"
        "threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGKILL)).start()\n"
        "workers.run('toy:faulty', scene, [0.0, 1.0], {'fault': 'hang'})\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == -signal.SIGKILL
    child = int(done.stdout)
    for _ in range(100):
        if not alive(child):
            return
        time.sleep(0.05)
    os.kill(child, signal.SIGKILL)
    pytest.fail("the worker is still there")


def alive(pid):
    """Whether the process runs; one that has ended and that nobody has waited for does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_a_patient_deadline_is_one_of_cpu_time(workers):
    """Who sleeps has no CPU time and is waited for as long as the patience lasts, and no longer."""
    faulty(workers, "none")  # the process is there, so that only the run is clocked
    begun = time.monotonic()
    asleep = workers.run("toy:faulty", SCENE, TIMES, {"fault": "hang"}, timeout=0.3, patience=6.0)
    waited = time.monotonic() - begun
    assert asleep.outcome.state == "timeout"
    assert "killed after 0.3 s of CPU time" in asleep.outcome.reason
    assert waited >= 6.0 * 0.3


def test_a_full_disk_of_the_notes_costs_the_notes_and_not_the_run(tmp_path):
    place = tmp_path / "notes"
    place.touch()
    with place.open("r+b", buffering=0) as file:
        scratch = Scratch(file)
        scratch.clear("advance")
        state = State(0.5, *(np.zeros((2, n)) for n in (3, 4, 3, 3)))
        scratch.add(state)
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (place.stat().st_size + 100, before[1]))
        try:
            scratch.add(state)  # of which the disk takes 100 bytes
            scratch.add(state)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        assert len(scratch.motion(2)) == 1
        scratch.add(state)
        assert len(scratch.motion(2)) == 2
