"""Lanes: who computes which cells, and when.

Where nothing is timed, every engine has one worker process and engines compute in parallel, whatever the scene.  Where
cost is measured, the cells of one scene sit together in one lane and take turns (`adapters.run.in_turns`), each engine
still in a process of its own; there are as many lanes as engines may compute at the same time.  Lanes are not
bound to processors: at a load of seven on two, that made the worst of 24 ratios of identical work 1.22, not 1.06.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from adapters.run import Failure, Run, in_turns, sample_times
from adapters.workers import Workers
from mechanics.trajectory import Trajectory
from plumbline.judging import step_of
from plumbline.plan import Job
from scenarios.phase import delays, later

if TYPE_CHECKING:
    from plumbline.campaign import Options


SITTING = 24  # cells that take turns: with more, as in a sweep, minutes would lie between two turns of the same cell


class Answer(NamedTuple):
    """What came of a job."""

    job: Job
    run: Run
    more: tuple[Run, ...]  # of the other phases of a step
    seconds: float  # that it took, all of its turns together


class Lanes:
    """Worker processes and the jobs they are at; a context manager.

    Parameters
    ----------
    options : Options
    """

    def __init__(self, options: Options) -> None:
        self.options = options
        self.timed = options.repeats > 1
        self._lanes = [Workers(options.memory) for _ in range(options.jobs if self.timed else 1)]
        self.threads = ThreadPoolExecutor(options.jobs)
        self._running: dict[Future[list[Answer]], tuple[tuple[Job, ...], Workers]] = {}

    @property
    def workers(self) -> Workers:
        """Workers of the first lane, for whatever is to be asked besides."""
        return self._lanes[0]

    @property
    def busy(self) -> bool:
        """Whether anything is being computed."""
        return bool(self._running)

    @property
    def told(self) -> str:
        """How cells are timed, for the record."""
        if not self.timed:
            return "none: every cell is run once"
        lanes = len(self._lanes)
        return (
            f"{self.options.repeats} repeats after a warm-up, the cells of a scene in turns A B B A, engines on one "
            f"thread each, {lanes} scene{'s' if lanes > 1 else ''} at a time"
        )

    def give(self, waiting: list[Job]) -> tuple[Job, ...]:
        """Take from `waiting` the next jobs that can begin now and begin them; none if nothing can."""
        if len(self._running) >= self.options.jobs or not waiting:
            return ()
        jobs = self._sitting(waiting) if self.timed else self._single(waiting)
        if jobs:
            taken = [lane for _, lane in self._running.values()]
            lane = next((lane for lane in self._lanes if lane not in taken), self.workers)
            self._running[self.threads.submit(self._ask, lane, jobs)] = (jobs, lane)
            waiting[:] = [job for job in waiting if job not in jobs]
        return jobs

    def _sitting(self, waiting: list[Job]) -> tuple[Job, ...]:
        """The jobs on the scene of the first, in the order of the plan, as many as take turns."""
        return tuple(job for job in waiting if job.scenario.name == waiting[0].scenario.name)[:SITTING]

    def _single(self, waiting: list[Job]) -> tuple[Job, ...]:
        """The first job in the order of the plan whose engine is free."""
        at_work = {job.engine for jobs, _ in self._running.values() for job in jobs}
        return next(((job,) for job in waiting if job.engine not in at_work), ())

    def finished(self) -> Iterator[Answer]:
        """Wait until something is finished: what came of it."""
        for future in wait(self._running, return_when=FIRST_COMPLETED).done:
            del self._running[future]
            yield from future.result()

    def _ask(self, workers: Workers, jobs: tuple[Job, ...]) -> list[Answer]:
        """The runs of some jobs, taken in turns, and then their other phases, which are not timed."""
        turns = [_Turns(workers, job, self.options) for job in jobs]
        runs = in_turns(turns, self.options.repeats)
        return [
            Answer(job, run, turn.others(run), turn.seconds) for job, run, turn in zip(jobs, runs, turns, strict=True)
        ]

    def close(self) -> None:
        """End every worker, in the middle of a run if need be."""
        for lane in self._lanes:
            lane.close()

    def __enter__(self) -> Lanes:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()  # before the threads are joined: they wait for their workers
        self.threads.shutdown()


class _Turns:
    """The turns of one job; called, it runs the job once."""

    def __init__(self, workers: Workers, job: Job, options: Options) -> None:
        self._workers, self._job, self._options = workers, job, options
        self.seconds = 0.0

    def __call__(self, sampled: bool = True, delay: float = 0.0) -> Run:
        job, options = self._job, self._options
        times = sample_times(job.scenario.duration, job.scenario.sampling)
        begun = time.monotonic()
        try:
            scene = later(job.scenario, delay).scene
            limits = options.timeout, options.patience
            return self._workers.run(job.engine, scene, times, job.settings, 1, *limits, sampled)
        except Exception as error:  # an adapter may raise outside of its process, too: when asked for its lead
            failure = Failure("error", "start", 0.0, f"{type(error).__name__}: {error}")
            return Run(job.engine, job.version, dict(job.settings), failure)
        finally:
            self.seconds += time.monotonic() - begun

    def others(self, run: Run) -> tuple[Run, ...]:
        """The other phases of a step; after one that broke none is risked, and none if the first did."""
        if not isinstance(run.outcome, Trajectory):
            return ()
        runs = [run]
        for delay in delays(self._job.scenario, self._options.phases, step_of(self._job.settings))[1:]:
            broken = not isinstance(runs[-1].outcome, Trajectory)
            runs.append(replace(runs[-1], partial=None) if broken else self(delay=delay))
        return tuple(runs[1:])
