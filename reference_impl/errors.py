"""What the engine says when it cannot go on; every error names the bodies and the time."""

from __future__ import annotations


class Unsupported(Exception):
    """Something of the scene that this engine has no part for; raised before the first step."""


class MissingEffect(Exception):
    """The motion needs an effect that the scene does not declare.

    Attributes
    ----------
    effect : str
    bodies : tuple of str
    time : float
        [s]
    """

    def __init__(self, effect: str, bodies: tuple[str, ...], time: float, why: str) -> None:
        self.effect, self.bodies, self.time = effect, bodies, time
        names = " and ".join(repr(b) for b in bodies)
        super().__init__(f"{why} ({names} at t = {time:.9g} s), but the scene does not declare {effect}")


class Overlap(Exception):
    """Bodies overlap where they must not: `depth` [m] of the pair `bodies` at `time` [s]."""

    def __init__(self, bodies: tuple[str, str], depth: float, time: float) -> None:
        self.bodies, self.depth, self.time = bodies, depth, time
        super().__init__(f"{bodies[0]!r} and {bodies[1]!r} overlap by {depth:.6g} m at t = {time:.9g} s")


class Stalled(Exception):
    """A budget ran out: `what` says which loop and where; the world keeps what was computed until then."""

    def __init__(self, what: str, time: float) -> None:
        self.what, self.time = what, time
        super().__init__(f"{what} at t = {time:.9g} s")
