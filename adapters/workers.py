"""One killable process per engine: a crash, a hang, running out of memory or an exception costs one cell.

The parent sends a job through a pipe and waits for the `Run` until the deadline.  What the child
prints goes to a file at the level of file descriptors, so nothing native escapes it.  Every state
the engine answers is also noted in a scratch file, outside the clocked call: after a crash the
parent reads there how far the run had come.

Processes are started as programs and not through `multiprocessing`: the child then does not import
the caller's main module again (a script needs no ``if __name__ == "__main__"``), has its environment
before numpy is imported (thread counts are read at that moment), and can be killed at once with
everything it has started.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adapters import registry
from adapters.engine import Settings, checked_settings, lead, settled
from adapters.run import Failure, Run, checked_times
from adapters.scratch import Scratch
from mechanics.scene import Scene

if TYPE_CHECKING:
    from adapters.conformance import Law

MEMORY = 8 * 2**30  # address space of a worker [bytes]; compilers and BLAS reserve far more than they use
TIMEOUT = 300.0  # of a job [s]
START_TIMEOUT = 120.0  # to start the process and import the engine [s]
TAIL = 4096  # bytes of output kept with a run

THREADS = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA", "BLIS")
SINGLE_THREADED = {f"{name}_NUM_THREADS": "1" for name in THREADS} | {"VECLIB_MAXIMUM_THREADS": "1"}
OUT_OF_MEMORY = re.compile(r"bad_?alloc|MemoryError|(could not|cannot|can't) allocate|out of memory", re.IGNORECASE)
CHILD = (
    "import json, sys; sys.path[:], *words = map(json.loads, sys.argv[1:]); "
    "from adapters.worker_process import serve; serve(*words)"
)


class Workers:
    """A worker for each engine, started when it is first needed; a context manager.

    Parameters
    ----------
    memory : int
        Address space a worker may use [bytes]; 0 = no limit.
    """

    def __init__(self, memory: int = MEMORY) -> None:
        self._memory = memory
        self._workers: dict[str, Worker] = {}
        self._lock = threading.Lock()
        self._closed = False

    def run(
        self,
        engine: str,
        scene: Scene,
        times: Sequence[float],
        settings: Settings | None = None,
        repeats: int = 1,
        timeout: float = TIMEOUT,
        patience: float = 1.0,
        sampled: bool = True,
    ) -> Run:
        """As `adapters.run.run`, in the engine's own process; whatever ends that process ends as a Run, too.

        Parameters
        ----------
        timeout : float
            Time after which the process is killed [s].
        patience : float
            At most so many times as long is waited for a process that has not had `timeout` seconds of CPU time:
            on a machine that is busy with other things an engine is not slow for that.
        sampled : bool
            As in `adapters.run.run`.

        Raises
        ------
        ValueError
            For times or settings that are not possible.
        Unavailable, UnknownName
            If there is no such engine here.
        """
        return self._worker(engine).run(scene, times, settings, repeats, timeout, patience, sampled)

    def check(self, engine: str, timeout: float = TIMEOUT) -> tuple[Law, ...] | Failure:
        """As `adapters.conformance.check_engine`, in the engine's own process; a Failure if it did not survive.

        Raises
        ------
        Unavailable, UnknownName
            If there is no such engine here.
        """
        return self._worker(engine).check(timeout)

    def _worker(self, engine: str) -> Worker:
        with self._lock:
            if self._closed:
                raise RuntimeError("the workers are closed")
            if engine not in self._workers:
                self._workers[engine] = Worker(engine, self._memory)
            return self._workers[engine]

    def close(self) -> None:
        """End every worker, in the middle of a run if need be."""
        with self._lock:
            self._closed = True
            for worker in self._workers.values():
                worker.close()

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class _Broken(Exception):
    """The process is gone; how."""

    def __init__(self, state: str, reason: str) -> None:
        self.state, self.reason = state, reason
        super().__init__(reason)


class Worker:
    """A process that runs one engine; started again after whatever ended it."""

    def __init__(self, engine: str, memory: int = MEMORY) -> None:
        self._engine = registry.engine(engine)
        self._target = registry.source_of(engine).target
        self._memory = memory
        self._process: subprocess.Popen[bytes] | None = None
        self._jobs: Connection | None = None
        self._answers: Connection | None = None
        self._lifeline: int | None = None  # nothing is ever written to it: the child ends when it closes
        self._busy = threading.Lock()
        self._closed = False
        self._scratch = Scratch()
        self._log = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115  lives as long as the worker
        fcntl.fcntl(self._log, fcntl.F_SETFL, fcntl.fcntl(self._log, fcntl.F_GETFL) | os.O_APPEND)

    def run(
        self,
        scene: Scene,
        times: Sequence[float],
        settings: Settings | None,
        repeats: int,
        timeout: float,
        patience: float = 1.0,
        sampled: bool = True,
    ) -> Run:
        """Run one job; see `Workers.run`."""
        chosen, at = checked_settings(self._engine, settings), checked_times(times)
        blank = Run(
            self._engine.name,
            self._engine.version,
            dict(chosen),
            Failure("error", "import", 0.0, ""),
            lead=lead(self._engine, settled(self._engine, chosen, scene)),
        )
        with self._busy:
            try:
                answer = self._do("run", (scene, at, chosen, repeats, sampled), timeout, patience)
                if not isinstance(answer, Run):
                    raise _Broken("error", answer)
            except _Broken as broken:
                answer = self._wreck(blank, broken, len(scene.bodies))
            answer = _short_of_memory(replace(answer, output=self._said()))
            if isinstance(answer.outcome, Failure) and answer.outcome.state == "oom":
                self._end()  # what a failed allocation left half done is not the next cell's concern
            return answer

    def check(self, timeout: float) -> tuple[Law, ...] | Failure:
        """Try the laws of adapters; see `Workers.check`."""
        with self._busy:
            try:
                answer = self._do("check", (), timeout)
                if not isinstance(answer, tuple):
                    raise _Broken("error", answer)
                return answer
            except _Broken as broken:
                return Failure(broken.state, self._scratch.stage, 0.0, f"{broken.reason}\n{self._said()}".strip())

    def close(self) -> None:
        """End the process, in the middle of a run if need be; that run ends as a crash."""
        self._closed = True
        self._kill()
        with self._busy:
            self._end()

    def _start(self) -> None:
        """Make sure that a process with the engine imported is there."""
        if self._process is not None and self._process.poll() is None:
            return
        self._end()
        if self._closed:
            raise _Broken("crash", "the worker is closed")
        jobs_read, jobs_write = os.pipe()
        answers_read, answers_write = os.pipe()
        lifeline_read, self._lifeline = os.pipe()
        inherited = (jobs_read, answers_write, self._scratch.fileno(), lifeline_read)
        words = [[str(p) for p in sys.path], self._target, self._engine.name, self._memory, *inherited]
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-u", "-X", "faulthandler", "-c", CHILD, *map(json.dumps, words)],
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=self._log,
                env=os.environ | SINGLE_THREADED,
                pass_fds=inherited,
                start_new_session=True,  # a Ctrl-C is the parent's to answer
            )
        finally:
            for descriptor in (jobs_read, answers_write, lifeline_read):
                os.close(descriptor)
        self._jobs, self._answers = Connection(jobs_write, readable=False), Connection(answers_read, writable=False)
        problem = self._receive(START_TIMEOUT)
        if problem:
            self._end()
            raise _Broken("error", problem)
        self._log.truncate(0)  # what is printed on import belongs to no cell

    def _do(self, task: str, words: tuple[Any, ...], timeout: float, patience: float = 1.0) -> Any:
        """What the process answers to a job; _Broken if it does not."""
        self._scratch.clear()
        self._log.truncate(0)
        self._start()
        assert self._jobs is not None
        try:
            self._jobs.send((task, words))
        except BrokenPipeError:
            raise self._death() from None
        return self._receive(timeout, patience)

    def _receive(self, timeout: float, patience: float = 1.0) -> Any:
        assert self._answers is not None
        try:
            if not self._answered(timeout, patience):
                self._end()
                raise _Broken("timeout", f"killed after {timeout:g} s{' of CPU time' if patience > 1.0 else ''}")
            return self._answers.recv()
        except (EOFError, OSError):
            raise self._death() from None

    def _answered(self, timeout: float, patience: float) -> bool:
        """Whether there is an answer before the deadline, which waits, with patience, for the process's CPU time."""
        assert self._answers is not None
        assert self._process is not None
        if patience <= 1.0:
            return self._answers.poll(timeout)
        due = _cpu_seconds(self._process.pid) + timeout
        last = time.monotonic() + patience * timeout
        wait = timeout
        while not self._answers.poll(max(wait, 0.05)):
            now = _cpu_seconds(self._process.pid)
            wait = min(due - now, last - time.monotonic()) if now < math.inf else 0.0
            if wait <= 0.0:
                return False
        return True

    def _death(self) -> _Broken:
        assert self._process is not None
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(5.0)
        code = self._process.returncode
        self._end()
        if code is None:
            return _Broken("crash", "the process closed its pipe and would not end")
        if code >= 0:
            return _Broken("crash", f"the process ended itself with exit code {code}")
        hint = " (not by the harness; the kernel does this when memory runs out)" if -code == signal.SIGKILL else ""
        return _Broken("crash", signal.Signals(-code).name + hint)

    def _kill(self) -> None:
        if self._process is not None and self._process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)

    def _end(self) -> None:
        self._kill()
        if self._process is not None:
            self._process.wait()
        for pipe in (self._jobs, self._answers):
            if pipe is not None:
                pipe.close()
        if self._lifeline is not None:
            os.close(self._lifeline)
        self._process = self._jobs = self._answers = self._lifeline = None

    def _wreck(self, blank: Run, broken: _Broken, bodies: int) -> Run:
        """What is known of a run that sent no answer."""
        motion, stage = self._scratch.motion(bodies), self._scratch.stage
        reached = float(motion.t[-1]) if motion is not None else 0.0
        where = f"{stage} after t = {reached:.6g} s" if stage == "advance" else stage
        reason = f"{broken.reason}, in {where}"
        return replace(blank, outcome=Failure(broken.state, stage, reached, reason), partial=motion)

    def _said(self) -> str:
        size = os.fstat(self._log.fileno()).st_size
        start = max(0, size - TAIL)
        return os.pread(self._log.fileno(), size - start, start).decode(errors="replace").strip()


def _cpu_seconds(process: int) -> float:
    """CPU time a process has had [s]; infinite where the system does not say, so that nobody waits for it."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return math.inf
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")  # utime and stime


def _short_of_memory(run: Run) -> Run:
    """The same run; a failure that speaks of memory, in whatever way the engine ended then, is called `oom`."""
    failure = run.outcome
    if not isinstance(failure, Failure) or failure.state not in ("error", "crash"):
        return run
    spoken = failure.reason + (run.output if failure.state == "crash" else "")
    return replace(run, outcome=replace(failure, state="oom")) if OUT_OF_MEMORY.search(spoken) else run
