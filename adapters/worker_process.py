"""The child of `adapters.workers`: one engine, jobs through a pipe, until the pipe closes."""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import sys
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from typing import Any

from adapters import registry
from adapters.run import run
from adapters.scratch import Scratch

OUTPUT_LIMIT = 2**30  # bytes of any file a worker writes: an engine that prints for ever must not fill the disk


def serve(target: str, name: str, memory: int, jobs_fd: int, answers_fd: int, scratch_fd: int, life_fd: int) -> None:
    """Import the engine, answer "" (or why not), then answer each job with what its task returns, or a sentence."""
    jobs, answers = Connection(jobs_fd, writable=False), Connection(answers_fd, readable=False)
    scratch = Scratch(os.fdopen(scratch_fd, "r+b", buffering=0))
    _end_with_parent(life_fd)
    _print_at_once()
    _limit(memory)
    try:
        engine = registry.load(target)[name]
    except (Exception, SystemExit) as error:
        answers.send(f"{type(error).__name__}: {error}")
        return
    answers.send("")
    with contextlib.suppress(EOFError, BrokenPipeError):  # the parent has gone
        while True:
            task, words = jobs.recv()
            _answer(answers, TASKS[task], Watched(engine, scratch), words)


def _check(watched: Watched) -> Any:
    from adapters.conformance import check_engine

    return check_engine(watched.engine)


def _answer(answers: Connection, task: Callable[..., Any], watched: Watched, words: tuple[Any, ...]) -> None:
    try:
        answer = task(watched, *words)
    except (Exception, SystemExit) as error:
        answer = f"{type(error).__name__}: {error}"
    _flush()
    try:
        answers.send(answer)
    except BrokenPipeError:
        raise
    except Exception as error:  # engines may report things that cannot be pickled
        answers.send(f"the run cannot be sent: {type(error).__name__}: {error}")


class Watched:
    """An engine that notes in a scratch file how far it has come.

    `advance` is the engine's own bound method, so nothing stands between the clock and the engine.
    """

    def __init__(self, engine: Any, scratch: Scratch) -> None:
        self.engine, self._scratch = engine, scratch
        self.advance = engine.advance

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def vacuum(self, scene: Any) -> Any:
        """As the engine; a repeat begins."""
        self._scratch.clear("build")
        return self.engine.vacuum(scene)

    def start(self, draft: Any, knobs: Mapping[str, Any]) -> Any:
        """As the engine."""
        self._scratch.enter("start")
        world = self.engine.start(draft, knobs)
        self._scratch.enter("read")
        return world

    def read(self, world: Any) -> Any:
        """As the engine; what follows is `advance`."""
        state = self.engine.read(world)
        self._scratch.add(state)
        self._scratch.enter("advance")
        return state


TASKS: dict[str, Callable[..., Any]] = {"run": run, "check": _check}


def _end_with_parent(life_fd: int) -> None:
    """Have the kernel end this process (SIGIO, whose default is to terminate) when the parent's end of the pipe closes.

    A parent that is killed cannot end its children, and one that hangs in native code would outlive it for ever.
    """
    fcntl.fcntl(life_fd, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(life_fd, fcntl.F_SETFL, fcntl.fcntl(life_fd, fcntl.F_GETFL) | os.O_ASYNC)


def _limit(memory: int) -> None:
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (OUTPUT_LIMIT, OUTPUT_LIMIT))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if memory:
            resource.setrlimit(resource.RLIMIT_AS, (memory, memory))


def _print_at_once() -> None:
    """Make C's stdout line-buffered; into a file it is not, and a crash loses what stands in the buffer."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        libc = ctypes.CDLL(None)
        libc.setvbuf(ctypes.c_void_p.in_dll(libc, "stdout"), None, 1, 0)


def _flush() -> None:
    sys.stdout.flush()
    sys.stderr.flush()
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).fflush(None)
