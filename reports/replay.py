"""Replay: what the player in the page needs to show the recorded motions of one scenario.

Display only.  Positions are multiples of a quantum from the middle of the picture, orientations of `TURN`, and only
some samples are kept: every one of a short recording, of a long one as many at equal distances as play smoothly and
between each two the one that lies farthest off the straight line, which is where something hits something.  Verdicts
never come from here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any
from urllib.parse import quote

import numpy as np

from comparisons.cell import Cell
from mechanics.effects import Hinge, Rod, Spring, Tether
from mechanics.rotation import angle_between, unrotate
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, bounding_radius
from mechanics.trajectory import Trajectory
from reports.drawing import svg
from reports.packing import packed, quantised
from reports.palette import slug
from reports.recorded import Recorded
from reports.series import Curves
from reports.verdict import BROKEN, RED, mark, ratio_text, sentence

FRAMES = 120  # at equal distances; a recording of at most twice as many samples is kept whole
ANGLE = 0.8  # [rad]; a turn by π between two samples would look like one the other way round
MOST = 600  # frames at equal distances
STEPS = 2**14  # quanta across the picture, far below a pixel
TURN = 2.0**-12  # quantum of the components of a unit quaternion
SIZE = (560.0, 220.0)  # of a figure [px]
TICKS = 2**24  # of the duration
OFF = 1e-3  # of the picture: what lies nearer to the straight line needs no sample of its own
LINKS = (Rod, Tether, Spring)


@dataclass(frozen=True)
class Replay:
    """One scenario for the player.

    Attributes
    ----------
    scenario : str
    block : str
        Everything to show, see `reports.packing`.
    moments : mapping
        Key of each cell that is shown -> time [s] at which it broke, or at which its worst error was worst; NaN
        where that belongs to no time.
    red : bool
        Whether some engine has a finding.
    """

    scenario: str
    block: str
    moments: Mapping[str, float]
    red: bool

    def link(self, key: str) -> str:
        """Fragment of the page that leads to the moment of a cell; "" if the cell is not shown."""
        if key not in self.moments:
            return ""
        when = self.moments[key]
        return f"#scene={quote(self.scenario, safe='')}" + ("" if math.isnan(when) else f"&t={when:.3f}")


def replay(of: Recorded, curves: Curves) -> Replay | None:
    """The replay of a scenario with its `curves`; None where nothing of it moves or its scene is not known."""
    scene = of.scene
    if scene is None or not of.motions:
        return None
    paths = {engine: motion.path for engine, motion in of.motions.items()}
    animated = [i for i, b in enumerate(scene.bodies) if not isinstance(b.shape, HalfSpace) and _moves(paths, i)]
    if not animated:
        return None
    turning = [i for i in animated if any(np.ptp(p.q[:, i], axis=0).any() for p in paths.values())]
    low, high = _box(scene, paths, animated)
    centre, quantum = 0.5 * (low + high), float((high - low).max()) / STEPS
    arrays, told = [], []
    for engine, path in paths.items():
        kept = frames(path.x[:, animated], OFF * STEPS * quantum, _turned(path.q[:, turning]))
        x = quantised(path.x[kept][:, animated], centre, quantum)
        q = quantised(_continuous(path.q[kept][:, turning]), 0.0, TURN)
        ticks = np.rint(path.t[kept] * (TICKS / of.duration)).astype(np.int32)
        arrays += [ticks[None], x.reshape(len(kept), -1).T, q.reshape(len(kept), -1).T]
        told.append(_engine(of.cells[engine]))
    header = {
        "scenario": of.scenario,
        "duration": of.duration,
        "tick": of.duration / TICKS,
        "centre": centre.tolist(),
        "size": (high - low).tolist(),
        "quantum": quantum,
        "turn": TURN,
        "planar": scene.out_of_plane() is None,
        "bodies": [_body(b) for b in scene.bodies],
        "animated": animated,
        "turning": turning,
        "links": links(scene),
        "engines": told,
        "figures": [{"title": f.title, "svg": svg(f, *SIZE)} for f in curves.figures],
    }
    cells = of.cells.values()
    moments = {c.key: moment(c) for c in cells}
    return Replay(of.scenario, packed(header, arrays), moments, any(c.state in RED for c in cells))


def moment(cell: Cell) -> float:
    """When the cell broke, or when its worst demanded error was worst [s]; NaN if that belongs to no time."""
    if cell.state in BROKEN:
        return cell.time
    return cell.worst.time if cell.worst is not None else math.nan


def frames(x: np.ndarray, off: float, turned: float = 0.0) -> np.ndarray:
    """Places of the samples to keep of (T, n, 3) positions of bodies that turn by up to `turned` [rad] in all.

    Every sample if there are at most 2 `FRAMES`; else `FRAMES` at equal distances, more if bodies turn by more than
    `ANGLE` between them, and of each stretch between two of them the sample that lies farthest off the straight line,
    if that is more than `off` [m].
    """
    count = len(x)
    if count <= 2 * FRAMES:
        return np.arange(count)
    even = round(min(max(FRAMES, turned / ANGLE), MOST))
    base = np.unique(np.rint(np.linspace(0, count - 1, even)).astype(int))
    before = np.minimum(np.searchsorted(base, np.arange(count), side="right") - 1, len(base) - 2)
    first, last = base[before], base[before + 1]
    part = ((np.arange(count) - first) / (last - first))[:, None, None]
    far = np.abs(x - (1.0 - part) * x[first] - part * x[last]).max(axis=(1, 2), initial=0.0)
    more = [a + int(np.argmax(far[a:b])) for a, b in pairwise(base)]
    return np.unique([*base, *(k for k in more if far[k] > off)])


def _moves(paths: Mapping[str, Trajectory], body: int) -> bool:
    return any(np.ptp(p.x[:, body], axis=0).any() or np.ptp(p.q[:, body], axis=0).any() for p in paths.values())


def _turned(q: np.ndarray) -> float:
    """Largest angle by which one of n bodies turns in all [rad], from (T, n, 4) quaternions."""
    return float(angle_between(q[1:], q[:-1]).sum(axis=0).max(initial=0.0))


def _continuous(q: np.ndarray) -> np.ndarray:
    """(T, n, 4) quaternions whose signs never jump: q and -q are the same orientation."""
    flips = np.where((q[1:] * q[:-1]).sum(axis=2) < 0.0, -1.0, 1.0)
    return np.concatenate([q[:1], q[1:] * np.cumprod(flips, axis=0)[..., None]])


def _box(scene: Scene, paths: Mapping[str, Trajectory], animated: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the picture [m]: all of the calmest motion, of others what is at most half as far again."""
    radius = np.array([[bounding_radius(scene.bodies[i].shape)] for i in animated])
    boxes = []
    for path in paths.values():
        x = path.x[:, animated]
        boxes.append(((np.nanmin(x, axis=0) - radius).min(axis=0), (np.nanmax(x, axis=0) + radius).max(axis=0)))
    calmest = boxes[0] if "reference" in paths else min(boxes, key=lambda box: float((box[1] - box[0]).max()))
    low, high = calmest
    reach = float((high - low).max())
    for body in scene.bodies:
        small = bounding_radius(body.shape)
        if body.fixed and small < reach:
            low, high = (
                np.minimum(low, np.array(body.position) - small),
                np.maximum(high, np.array(body.position) + small),
            )
    wide = 0.5 * float((high - low).max())
    least, most = (np.array(corner) for corner in zip(*boxes, strict=True))
    low, high = (
        np.maximum(np.minimum(low, least.min(axis=0)), low - wide),
        np.minimum(np.maximum(high, most.max(axis=0)), high + wide),
    )
    return low, high


def _engine(cell: Cell) -> dict[str, Any]:
    sign, when = mark(cell), moment(cell)
    return {
        "name": cell.engine,
        "slug": slug(cell.engine),
        "glyph": sign.glyph,
        "word": sign.word,
        "tone": sign.tone,
        "ratio": ratio_text(cell),
        "why": sentence(cell),
        "fails": cell.state in ("fail", "xfail", *BROKEN),
        "moment": None if math.isnan(when) else when,
    }


def _body(body: Body) -> dict[str, Any]:
    shape = {"kind": type(body.shape).__name__, **vars(body.shape)}
    return {"name": body.name, "fixed": body.fixed, "shape": shape, "x": body.position, "q": body.orientation}


def links(scene: Scene) -> list[dict[str, Any]]:
    """Rods, tethers and springs between their anchors, and an arm from each body to the hinge it turns about."""
    found = [
        {"kind": type(e).__name__, "a": scene.index(e.a), "b": scene.index(e.b), "p": e.anchor_a, "q": e.anchor_b}
        | ({"length": e.length} if isinstance(e, Tether) else {})
        for kind in LINKS
        for e in scene.all(kind)
    ]
    for hinge in scene.all(Hinge):
        for name in (hinge.a, hinge.b):
            body = scene.body(name)
            if not isinstance(body.shape, HalfSpace):
                at = unrotate(np.array(body.orientation), np.array(hinge.point) - np.array(body.position))
                i = scene.index(name)
                found.append({"kind": "Hinge", "a": i, "b": i, "p": (0.0, 0.0, 0.0), "q": at.tolist()})
    return found
