"""From nothing to the first step in a fresh process, with compiled code in the cache."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time

from benchmarks.row import Figure, Row

COMMON = """
from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.simulate import simulate
floor, box = Body("floor", HalfSpace()), Box((1.0, 1.0, 1.0))
"""
SCENES = {
    "a sphere that bounces": """
body = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1001))
scene = Scene((floor, body), (Gravity(), Restitution(0.8)))
""",
    "a box at rest": """
body = Body("box", box, 1.0, (0.0, 0.0, 0.5))
scene = Scene((floor, body), (Gravity(), Rotation(), Resting()))
""",
    "a box that slides with friction": """
body = Body("box", box, 1.0, (0.0, 0.0, 0.5), velocity=(1.0, 0.0, 0.0))
scene = Scene((floor, body), (Gravity(), Rotation(), Friction(0.3), Resting()))
""",
}
RUN = "simulate(scene, [0.0, 0.01])\n"
TOOLS = "import numpy, numba\n"


def seconds(program: str) -> tuple[float, float]:
    """Wall and processor time of a fresh Python process that runs `program` [s]; it keeps byte code, as is the default.

    Raises
    ------
    subprocess.CalledProcessError
        If it fails.
    """
    keeping = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    begun, used = time.perf_counter(), _used()
    subprocess.run([sys.executable, "-c", program], check=True, timeout=300.0, env=keeping)
    return time.perf_counter() - begun, _used() - used


def _used() -> float:
    """Processor time of all processes started from here that have ended [s]."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def measure(tiny: bool = False) -> Row:
    """The best of several processes each, after one that fills the cache."""
    repeats = 1 if tiny else 5
    scenes = dict(list(SCENES.items())[:1]) if tiny else SCENES
    figures, used = [], []
    for name, scene in scenes.items():
        program = COMMON + scene + RUN
        seconds(program)
        wall, processor = _best(program, repeats)
        figures.append(Figure(name, wall, 1.0, "s"))
        used.append(processor)
    wall, processor = _best(TOOLS, repeats)
    return Row(
        name="startup",
        subject="import and first step, warm cache",
        figures=tuple(figures),
        how=f"wall time of a fresh process from its start to its end, the best of {repeats}; a process that does "
        f"nothing but import numpy and numba takes {wall:.2f} s of it; processor time, the wall time of a machine with "
        f"nothing else to do: {', '.join(f'{u:.2f} s' for u in used)}, and {processor:.2f} s",
        missed="the machine was busy, as the processor time tells" if max(used) <= 1.0 else "",
    )


def _best(program: str, repeats: int) -> tuple[float, float]:
    """Least wall and least processor time of several runs [s]."""
    wall, processor = zip(*(seconds(program) for _ in range(repeats)), strict=True)
    return min(wall), min(processor)
