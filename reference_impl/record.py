"""What a result tells of contacts: lasting ones, and all impulses in rows of arrays that grow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, overload

import numpy as np

ROOM = 1024  # impulses a new record has room for


class Collided(NamedTuple):
    """One impulse that was exchanged."""

    time: float  # [s]
    a: int
    b: int
    point: tuple[float, float, float]  # [m]
    normal: tuple[float, float, float]  # unit, from b to a
    impulse: float  # on a along the normal [N s]


class Held(NamedTuple):
    """A lasting contact and its force."""

    a: int
    b: int
    point: tuple[float, float, float]  # [m]
    normal: tuple[float, float, float]  # unit, from b to a
    force: float  # on a along the normal [N]
    friction: tuple[float, float, float] = (0.0, 0.0, 0.0)  # on a along the surface [N]


class Record(Sequence[Collided]):
    """Impulses in the order of time.

    Attributes
    ----------
    ends : (room, 2) array of int
        Bodies a and b.
    numbers : (room, 8) array
        Time [s], point (3) [m], normal (3), impulse [N s]; rows from `len(self)` on are free.
    """

    def __init__(self) -> None:
        self.ends, self.numbers = np.empty((ROOM, 2), dtype=np.int64), np.empty((ROOM, 8))
        self._count = 0

    def append(self, one: Collided) -> None:
        """Add one impulse."""
        if self._count == len(self.ends):
            self.grow()
        self.ends[self._count] = one.a, one.b
        self.numbers[self._count] = one.time, *one.point, *one.normal, one.impulse
        self._count += 1

    def grow(self) -> None:
        """Twice the room."""
        self.ends = np.concatenate([self.ends, np.empty_like(self.ends)])
        self.numbers = np.concatenate([self.numbers, np.empty_like(self.numbers)])

    def filled(self, count: int) -> None:
        """Declare the first `count` rows, written from outside, part of the record."""
        self._count = count

    def _row(self, k: int) -> Collided:
        (a, b), row = self.ends[k].tolist(), self.numbers[k].tolist()
        return Collided(row[0], a, b, (row[1], row[2], row[3]), (row[4], row[5], row[6]), row[7])

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, k: int) -> Collided: ...
    @overload
    def __getitem__(self, k: slice) -> list[Collided]: ...
    def __getitem__(self, k: int | slice) -> Collided | list[Collided]:
        if isinstance(k, slice):
            return [self._row(i) for i in range(*k.indices(self._count))]
        if not -self._count <= k < self._count:
            raise IndexError(f"impulse {k} of {self._count}")
        return self._row(k % self._count)

    def __iter__(self) -> Iterator[Collided]:
        return (self._row(k) for k in range(self._count))
