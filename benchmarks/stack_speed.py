"""A stack of twenty boxes beside PyBullet: what a simulated second costs, standing and gliding along."""

from __future__ import annotations

from adapters.run import Run
from benchmarks.engines import FAIR, REFERENCE, beside, played
from benchmarks.row import Beside, Figure, Row
from benchmarks.stack import load_error, scene

GLIDING = (0.5, 0.0, 0.0)  # [m/s]: the stack never comes to proven rest, every step has to be taken
SAMPLING = 1.0 / 60.0  # [s]


def measure(tiny: bool = False) -> Row:
    """One second, at 60 samples; engines take the steps of their fair profiles, 1 ms."""
    masses = (1.0,) * (3 if tiny else 20)
    samples = 6 if tiny else 60
    times = [k * SAMPLING for k in range(samples + 1)]
    error = load_error(masses)

    def cost(engine: str, velocity: tuple[float, float, float]) -> Beside:
        found: Run = played(scene(masses, velocity), times, engine, repeats=1 if tiny else 2)
        return beside(found, error)

    standing = {name: cost(name, (0.0, 0.0, 0.0)) for name in (REFERENCE, *FAIR)}
    gliding = {name: cost(name, GLIDING) for name in (REFERENCE, *FAIR)}
    figures = []
    for what, found in (("standing", standing), ("gliding", gliding)):
        ours, theirs = found[REFERENCE], found["pybullet"]
        figures += [
            Figure(f"{what}: speed over PyBullet's", theirs.seconds / ours.seconds, 0.5, at_least=True),
            Figure(
                f"{what}: PyBullet's error of the loads over the reference's",
                theirs.error / max(ours.error, 1e-17),
                1e6,
                at_least=True,
            ),
        ]
    return Row(
        name="stack-speed",
        subject=f"a stack of {len(masses)} boxes beside engines in their fair profiles",
        figures=tuple(figures),
        how="smooth boxes, 60 samples a second; standing, the reference proves the stack to be at rest and takes no "
        "steps; gliding at 0.5 m/s it never is, and every step is taken; an error below 1e-17 counts as that",
        judged="loads, relative",
        beside=tuple(
            Beside(f"{name}, {what}", b.error, b.seconds, b.note)
            for what, found in (("standing", standing), ("gliding", gliding))
            for name, b in found.items()
        ),
    )
