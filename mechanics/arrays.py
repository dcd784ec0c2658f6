"""Array types with their shapes, and the one gate through which user values become numbers.

Whatever a user writes passes `real` or `reals` once: afterwards every value is a finite float of the
promised shape, and nothing further down has to ask again.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING or "jaxtyping" in sys.modules:  # tests load it first, to check shapes as they run
    from jaxtyping import Float64, Int

    Vec3 = Float64[np.ndarray, "3"]
    Quat = Float64[np.ndarray, "4"]
    Mat33 = Float64[np.ndarray, "3 3"]
    Vectors = Float64[np.ndarray, "... 3"]
    Quats = Float64[np.ndarray, "... 4"]
    Matrices = Float64[np.ndarray, "... 3 3"]
    Scalars = Float64[np.ndarray, "..."] | float  # a single angle is a NumPy float
    Triangles = Int[np.ndarray, "n 3"]
    Places = Float64[np.ndarray, "n 3"]
    Turns = Float64[np.ndarray, "n 4"]
    Times = Float64[np.ndarray, "T"]
    Paths = Float64[np.ndarray, "T n 3"]
    Turnings = Float64[np.ndarray, "T n 4"]
else:  # elsewhere nothing looks at shapes, and importing it would be a fifth of the time to the first step
    Vec3 = Quat = Mat33 = Vectors = Quats = Matrices = Triangles = np.ndarray
    Places = Turns = Times = Paths = Turnings = np.ndarray
    Scalars = np.ndarray | float

Triple = tuple[float, float, float]


class SceneError(ValueError):
    """A value that cannot be part of a scene: names the field, the value and what is allowed.

    Attributes
    ----------
    field : str
        Where the value stands, for example ``body 'ball'.mass`` or, from a file, ``body[2].mass``.
    value : object
        The offending value as it was given.
    allowed : str
        What would have been accepted.
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field, self.value, self.allowed = field, value, allowed
        super().__init__(f"{field} = {value!r} is not possible: {allowed}")

    def __reduce__(self) -> tuple[type[SceneError], tuple[str, object, str]]:
        return type(self), (self.field, self.value, self.allowed)

    def within(self, prefix: str) -> SceneError:
        """Return the same error with `prefix` put before the field, as seen from further out."""
        return type(self)(f"{prefix}.{self.field}" if self.field else prefix, self.value, self.allowed)


def real(
    field: str, value: object, *, above: float | None = None, least: float | None = None, most: float | None = None
) -> float:
    """Return `value` as a finite float.

    Parameters
    ----------
    field : str
        Name used in the error.
    above, least, most : float, optional
        Strict lower, lower and upper bound.

    Raises
    ------
    SceneError
        If the value is no number, not finite, or out of bounds.
    """
    bounds = [
        f"> {above:g}" if above is not None else "",
        f">= {least:g}" if least is not None else "",
        f"<= {most:g}" if most is not None else "",
    ]
    allowed = " and ".join(["a finite number", *filter(None, bounds)])
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise SceneError(field, value, allowed)
    number = float(value)
    if (
        not math.isfinite(number)
        or (above is not None and number <= above)
        or (least is not None and number < least)
        or (most is not None and number > most)
    ):
        raise SceneError(field, value, allowed)
    return number


def reals(field: str, value: object, count: int, *, above: float | None = None) -> tuple[float, ...]:
    """Return `value` as a tuple of `count` finite floats, each greater than `above` if that is given.

    Raises
    ------
    SceneError
        If `value` is no sequence of `count` such numbers.
    """
    allowed = f"{count} finite numbers" + (f" > {above:g}" if above is not None else "")
    if isinstance(value, (str, bytes)) or not isinstance(value, (Sequence, np.ndarray)) or len(value) != count:
        raise SceneError(field, value, allowed)
    try:
        return tuple(real(field, item, above=above) for item in value)
    except SceneError:
        raise SceneError(field, value, allowed) from None


def frozen(values: Iterable[object] | np.ndarray) -> np.ndarray:
    """Return a read-only, C-contiguous float64 copy of `values`."""
    array = np.array(values, dtype=np.float64, order="C")
    array.setflags(write=False)
    return array
