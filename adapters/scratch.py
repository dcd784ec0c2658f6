"""Scratch file in which a worker notes how far a run has come, so that its parent knows after a crash.

A file and not a pipe: what was written to it is there whatever becomes of the writer.  What a full disk does not take
is left out and costs nothing but the motion of a run that crashes: it is no fault of the engine.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from typing import IO, Any

import numpy as np

from adapters.run import STAGES
from mechanics.trajectory import State, Trajectory

HEAD = 8  # bytes before the first record


class Scratch:
    """Stage in byte 0; from byte `HEAD` on records of 1 + 13 n numbers: t, x, q, v, w of n bodies.

    Parameters
    ----------
    file : binary file, optional
        Without one: a temporary file without a name.
    """

    def __init__(self, file: IO[bytes] | None = None) -> None:
        self._file: Any = file or tempfile.TemporaryFile(buffering=0)  # noqa: SIM115  lives as long as this object

    def fileno(self) -> int:
        """File descriptor, for the child to inherit."""
        return int(self._file.fileno())

    def clear(self, stage: str = "import") -> None:
        """Forget all states; the run, or one of its repeats, begins at `stage`."""
        os.ftruncate(self.fileno(), HEAD)
        self.enter(stage)

    def enter(self, stage: str) -> None:
        """Note the stage, one of `adapters.run.STAGES`."""
        with suppress(OSError):
            os.pwrite(self.fileno(), bytes([STAGES.index(stage)]), 0)

    def add(self, state: State) -> None:
        """Note a state, whole or not at all."""
        row = np.concatenate([np.ravel(part) for part in (state.t, state.x, state.q, state.v, state.w)])
        data, size, written = row.astype(np.float64).tobytes(), os.fstat(self.fileno()).st_size, 0
        with suppress(OSError):
            written = os.pwrite(self.fileno(), data, size)
        if written < len(data):
            os.ftruncate(self.fileno(), size)

    @property
    def stage(self) -> str:
        """The stage noted last."""
        return STAGES[os.pread(self.fileno(), 1, 0)[0]]

    def motion(self, bodies: int) -> Trajectory | None:
        """Trajectory of the states noted of that many bodies, or None; a record cut short is left out."""
        width = 1 + 13 * bodies
        data = os.pread(self.fileno(), os.fstat(self.fileno()).st_size, HEAD)
        count = len(data) // (8 * width)
        if not count:
            return None
        rows = np.frombuffer(data, count=count * width).reshape(count, width)
        t, x, q, v, w = np.split(rows, np.cumsum([1, 3 * bodies, 4 * bodies, 3 * bodies]), axis=1)
        return Trajectory(t[:, 0], *(part.reshape(count, bodies, -1) for part in (x, q, v, w)))
