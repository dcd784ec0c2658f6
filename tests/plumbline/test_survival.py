"""Whatever ends a campaign, nothing that was finished is lost, the message says what happened, and it goes on."""

import json
import os
import random
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from plumbline.results import Results

ROOT = Path(__file__).parents[2]
TOYS = ROOT / "tests" / "adapters" / "toy_engines.py"
WORDS = ["run", "-s", "projectile", "-s", "free-fall", "-e", "toy", "-e", "toy:faulty",
         "--plugin", str(TOYS), "--repeats", "1", "--fail-on", "harness", "--progress", "off"]  # fmt: skip
STEPS = [word for k in range(1, 4) for word in ("--set", f"dt={0.1 / k:.6f}")]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def start(folder, *words, **more):
    return subprocess.Popen([sys.executable, "-m", "plumbline", *WORDS, *words, "--out", str(folder)], text=True,
                            env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)  # fmt: skip


def finish(folder, *words, **more):
    """Run to the end; (exit code, stderr)."""
    process = start(folder, *words, **more)
    _, err = process.communicate(timeout=120)
    return process.returncode, err


def whole_lines(folder):
    """Lines of the journal that were finished, as they stand there."""
    journal = folder / "cells.jsonl"
    lines = journal.read_text().splitlines(keepends=True) if journal.exists() else []
    return [line for line in lines if line.endswith("\n")]


def answers(folder):
    return {c.key: (c.state, c.digest) for c in Results.read(folder).cells}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The run as it is if it is left alone."""
    folder = tmp_path_factory.mktemp("undisturbed") / "run"
    code, err = finish(folder, *STEPS)
    assert (code, err) == (0, "")
    assert {state for state, _ in answers(folder).values()} == {"ok"}
    return folder


def test_killed_at_random_moments_it_goes_on_where_it_stopped(undisturbed, tmp_path):
    folder, seed = tmp_path / "run", random.Random(6)
    kept = []
    for _ in range(3):
        process = start(folder, *STEPS)
        least = len(kept) + seed.randrange(1, 7)
        deadline = time.monotonic() + 60.0
        while len(whole_lines(folder)) < least and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.005)
        time.sleep(seed.random() * 0.02)  # anywhere between two cells
        process.kill()
        process.communicate()
        assert whole_lines(folder)[: len(kept)] == kept
        kept = whole_lines(folder)
    assert len(kept) < len(answers(undisturbed))
    assert finish(folder, *STEPS) == (0, "")
    assert whole_lines(folder)[: len(kept)] == kept  # no cell that was finished was run again
    keys = [json.loads(line)["key"] for line in whole_lines(folder)]
    assert len(set(keys)) == len(keys)
    assert answers(folder) == answers(undisturbed)
    assert not list(folder.rglob("*.part"))


def test_a_line_that_a_kill_cut_short_is_the_only_one_run_again(undisturbed, tmp_path):
    folder = shutil.copytree(undisturbed, tmp_path / "run")
    lines = whole_lines(folder)
    (folder / "cells.jsonl").write_text("".join(lines)[:-40])
    assert finish(folder, *STEPS) == (0, "")
    assert whole_lines(folder)[:-1] == lines[:-1]
    assert len(whole_lines(folder)) == len(lines)
    assert answers(folder) == answers(undisturbed)


def limited(size):
    """Files of the process may not grow beyond `size` bytes: like a full disk, a write stops in the middle."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def test_where_no_more_can_be_written_it_stops_with_the_reason_and_goes_on_later(undisturbed, tmp_path):
    folder = tmp_path / "run"
    code, err = finish(folder, *STEPS, preexec_fn=limited((undisturbed / "cells.jsonl").stat().st_size // 2))
    kept = whole_lines(folder)
    assert code == 4
    assert f"cannot write to {folder}: File too large; cells that are in the journal are kept" in err
    assert "Traceback" not in err
    assert 0 < len(kept) < len(answers(undisturbed))
    assert finish(folder, *STEPS) == (0, "")
    assert whole_lines(folder)[: len(kept)] == kept
    assert answers(folder) == answers(undisturbed)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may mount a small file system")
def test_a_disk_that_is_full_stops_it_with_the_reason(undisturbed, tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=128k", "plumbline", disk], capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        code, err = finish(disk / "run", *STEPS)
        kept = whole_lines(disk / "run")
        assert code == 4
        assert "No space left on device; cells that are in the journal are kept" in err
        assert "Traceback" not in err
        assert 0 < len(kept) < len(answers(undisturbed))
        subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
        assert finish(disk / "run", *STEPS) == (0, "")
        assert whole_lines(disk / "run")[: len(kept)] == kept
        assert answers(disk / "run") == answers(undisturbed)
    finally:
        subprocess.run(["umount", disk], check=True)


def test_a_folder_that_may_not_be_written_is_named_before_anything_is_run(tmp_path):
    closed, reason = tmp_path / "closed", "Permission denied"
    closed.mkdir(mode=0o555)
    root = os.geteuid() == 0
    if root:  # who may write everywhere, but not on a file system that is read-only
        reason = "Read-only file system"
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "plumbline", closed], capture_output=True).returncode:
            pytest.skip("no file system can be mounted here")
    try:
        code, err = finish(closed / "run")
        assert code == 4
        assert f"cannot write to {closed / 'run'}: {reason}" in err
        assert "Traceback" not in err
        assert not any(closed.iterdir())
    finally:
        if root:
            subprocess.run(["umount", closed], check=True)
