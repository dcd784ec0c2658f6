"""Motion: the state of all bodies at one time, and at many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b

import numpy as np

from mechanics.arrays import Paths, Places, Times, Turnings, Turns, frozen


@dataclass(frozen=True)
class State:
    """Positions and velocities of n bodies, in scene order, at one time.

    Attributes
    ----------
    t : float
        Time [s].
    x, v : (n, 3) arrays
        Position [m] and velocity [m/s] of the centres of mass, world frame.
    q : (n, 4) array
        Unit quaternions (w, x, y, z), body to world.
    w : (n, 3) array
        Angular velocity [rad/s], world frame.
    """

    t: float
    x: Places
    q: Turns
    v: Places
    w: Places


@dataclass(frozen=True)
class Trajectory:
    """States of n bodies at T times; a truth may hold NaN where nothing is known.

    Attributes
    ----------
    t : (T,) array
        Times [s], increasing.
    x, v, w : (T, n, 3) arrays; q : (T, n, 4) array
        As in `State`.
    """

    t: Times
    x: Paths
    q: Turnings
    v: Paths
    w: Paths

    def __post_init__(self) -> None:
        for name in ("t", "x", "q", "v", "w"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.t)

    def at(self, k: int) -> State:
        """State at sample k."""
        return State(float(self.t[k]), self.x[k], self.q[k], self.v[k], self.w[k])

    def until(self, count: int) -> Trajectory:
        """The first `count` samples."""
        return Trajectory(self.t[:count], self.x[:count], self.q[:count], self.v[:count], self.w[:count])

    def digest(self) -> str:
        """Hash of the last state, bit by bit: equal digests mean identical answers."""
        parts = b"".join(np.ascontiguousarray(a[-1]).tobytes() for a in (self.x, self.q, self.v, self.w))
        return blake2b(parts, digest_size=16).hexdigest()

    @staticmethod
    def of(states: Sequence[State]) -> Trajectory:
        """Trajectory through `states`, in the order given."""
        return Trajectory(
            np.array([s.t for s in states], dtype=np.float64),
            *(np.stack([getattr(s, name) for s in states]) for name in ("x", "q", "v", "w")),
        )
