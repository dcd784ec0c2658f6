"""Compiled code on disk: loaded quickly, and compiled by one process where several need it."""

from __future__ import annotations

import hashlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FunctionType
from typing import Any, BinaryIO, ClassVar

import numpy as np
from numba.core.caching import FunctionCache
from numba.core.runtime import rtsys

try:
    import fcntl
except ImportError:  # not a POSIX system: processes do not wait for each other there
    fcntl = None  # type: ignore[assignment]

PATIENCE = 60.0  # time another process is given to compile a kernel, before it is compiled here as well [s]
GLANCE = 0.01  # time between two looks whether it is done [s]


class Kept(FunctionCache):
    """Compiled code on disk, which is loaded without making numba ready to compile.

    Getting ready takes longer than loading does, and loaded code needs none of it but the memory of its arrays.
    """

    def __init__(self, function: FunctionType) -> None:
        super().__init__(function)
        self.turn = Turn(self._cache_file._index_path)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What numba keeps for the signature; None if it must be compiled, for which it is this process's turn."""
        with _no_blas(), self._guard_against_spurious_io_errors():
            rtsys.initialize(target_context)
            found = self._load_overload(sig, target_context)
            if found is None:
                self.turn.take()
                found = self._load_overload(sig, target_context)  # by whom it has waited for
            if found is None:
                target_context.refresh()
            else:
                for environment in (found.environment, *found.referenced_envs):
                    environment.consts[:] = [_the_one(value) for value in environment.consts]
            return found
        return None  # where the guard has swallowed an exception


class Turn:
    """The right to compile one kernel, which one process has at a time.

    A kernel's callees are compiled while it has its turn, and as kernels do not call themselves nobody waits for
    who waits for him.  It is a lock on one byte of a file beside the compiled code, and ends with the process.

    Parameters
    ----------
    name : str
        Path of the list of what is kept of the kernel.
    """

    files: ClassVar[dict[str, BinaryIO]] = {}  # by folder; to close one would end the turns of all kernels in it

    def __init__(self, name: str) -> None:
        self.folder, file = os.path.split(name)
        self.byte = int.from_bytes(hashlib.sha256(file.encode()).digest()[:7], "big")
        self.mine = False

    def take(self) -> None:
        """Wait until no other process has the turn, but not longer than PATIENCE."""
        if fcntl is None or self.mine:
            return
        if self.folder not in self.files:
            os.makedirs(self.folder, exist_ok=True)
            self.files[self.folder] = open(os.path.join(self.folder, "compiling.lock"), "ab")  # noqa: SIM115
        until = time.monotonic() + PATIENCE
        while not self.mine:
            try:
                fcntl.lockf(self.files[self.folder], fcntl.LOCK_EX | fcntl.LOCK_NB, 1, self.byte)
                self.mine = True
            except (BlockingIOError, PermissionError):  # it is another one's
                if time.monotonic() > until:
                    return
                time.sleep(GLANCE)
            except OSError:  # no locks in this file system
                return

    def end(self) -> None:
        """Let others have it."""
        if self.mine:
            fcntl.lockf(self.files[self.folder], fcntl.LOCK_UN, 1, self.byte)
            self.mine = False


def in_turn(compile_: Callable[[Any], Any], kept: Kept, sig: Any) -> Any:
    """Compile or load, and end the turn that this may have taken, whether it succeeds or not."""
    try:
        return compile_(sig)
    finally:
        kept.turn.end()


def _the_one(value: object) -> object:
    """The one object that numpy has for a plain type of numbers, of which pickling makes copies.

    Compiled code finds its constants by their place in a list, and numba looks by identity whether one is there
    already.  Where a function is compiled in a process that has loaded one that calls it, a copy gave it a second
    place, which the list of a third process lacks.
    """
    return np.dtype(value.str) if isinstance(value, np.dtype) and value.fields is None else value


@contextmanager
def _no_blas() -> Iterator[None]:
    """Let numba not look for a BLAS within.

    It does so by importing scipy.linalg, which takes as long as loading all kernels of a scene.  A kernel that
    needs one has it imported when it runs; other users of numba in this process still get theirs.
    """
    if "scipy.linalg.cython_blas" in sys.modules or "numba.np.arraymath" in sys.modules:
        yield
        return
    sys.modules["scipy.linalg.cython_blas"] = None  # type: ignore[assignment]  # "there is none"
    try:
        yield
    finally:
        del sys.modules["scipy.linalg.cython_blas"]
        if "numba.np.arraymath" in sys.modules:
            sys.modules["numba.np.arraymath"]._HAVE_BLAS = True  # type: ignore[attr-defined]
