"""Numbers for display in few bytes: integers as differences in time, byte planes, gzip, base64.

A block is the base64 text of a gzip stream: the length of a JSON header (32 bits, little-endian), the header, and
the arrays it lists under "arrays" as [rows, columns, bytes per number].  Every array stands for signed integers;
each row holds the differences of neighbours (the first from 0, all modulo the width of the numbers), and the lowest
bytes of the whole array come first, then the next ones.  Neighbours in time are alike, so that most bytes are 0.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

VERSION = 1
MISSING = -32768  # of 16 bits: where there is no number
MOST = 32767


def quantised(values: np.ndarray, origin: np.ndarray | float, quantum: float) -> np.ndarray:
    """`values` as 16-bit multiples of `quantum` from `origin`; beyond them clipped, NaN as `MISSING`."""
    steps = np.rint((values - origin) / quantum)
    whole = np.where(np.isnan(steps), MISSING, np.clip(steps, -MOST, MOST))
    return np.asarray(whole, dtype=np.int16)


def packed(header: Mapping[str, Any], arrays: Sequence[np.ndarray]) -> str:
    """A block of `header` and two-dimensional `arrays` of 16- or 32-bit integers."""
    shapes = [[*a.shape, a.dtype.itemsize] for a in arrays]
    text = json.dumps({"version": VERSION, **header, "arrays": shapes}, separators=(",", ":")).encode()
    parts = [len(text).to_bytes(4, "little"), text, *map(_planes, arrays)]
    return base64.b64encode(gzip.compress(b"".join(parts), 6, mtime=0)).decode()


def unpacked(block: str) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Header and arrays of a block.

    Raises
    ------
    ValueError
        If it is of another version.
    """
    data = gzip.decompress(base64.b64decode(block))
    start = 4 + int.from_bytes(data[:4], "little")
    header = json.loads(data[4:start])
    if header["version"] != VERSION:
        raise ValueError(f"block of version {header['version']}; this one reads version {VERSION}")
    arrays = []
    for rows, columns, width in header["arrays"]:
        size = rows * columns * width
        planes = np.frombuffer(data, np.uint8, size, start).reshape(width, -1)
        whole = np.ascontiguousarray(planes.T).view(f"<i{width}").reshape(rows, columns)
        arrays.append(np.cumsum(whole, axis=1, dtype=whole.dtype))
        start += size
    return header, arrays


def _planes(whole: np.ndarray) -> bytes:
    steps = np.diff(whole, axis=1, prepend=whole.dtype.type(0))
    width = whole.dtype.itemsize
    single = np.frombuffer(steps.astype(f"<i{width}").tobytes(), np.uint8)
    return single.reshape(-1, width).T.tobytes()
