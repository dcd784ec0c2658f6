"""Figures others have published, which our runs must reproduce: a check of the harness from outside.

Nobody who published them knew of this project.  If the same scene, built from its description alone,
gives the same five digits in another version of the engine, then scene, adapter and measure are right.

* SimBenchmark (Kang and Hwangbo 2018), test "bouncing": mean square energy error of 49 elastic balls.
  Its Bullet is the reduced-coordinate solver, our `pybullet:multibody`.  Its ODE is a semi-implicit
  Euler scheme with an exact contact; so are `pybullet` and, in a plane, `pymunk`.
* Gazebo boxes (Peters and Hsu 2014, 2015), test "complex": largest errors of a tumbling box in flight.
  Its ODE treats the gyroscopic torque explicitly, as MuJoCo's Euler integrator and
  `pybullet:multibody` do; its Bullet implicitly, as MuJoCo's implicitfast and `pybullet` do.  Two
  engines that share a scheme share its error to the last digit.

One figure agrees to four digits only: ODE's angular momentum.  ODE turns the attitude by
q + h ω q/2, made a unit quaternion, where the others turn it by the exact rotation; with that rule explicit
Euler gives 0.0130709 for the 0.0130708 published, with the exact rotation 0.0130699.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from scenarios import gazebo_boxes, simbenchmark_bouncing
from scenarios.catalogue import families

SIMBENCHMARK = "SimBenchmark (Kang and Hwangbo 2018), github.com/leggedrobotics/SimBenchmark, data/bouncing/sample.csv"
GAZEBO = "Peters and Hsu 2015, github.com/scpeters/benchmark, test_results/BENCHMARK_boxes_dt.csv"

# step [s] -> mean square energy error [J2], rows BULLET,MULTIBODY and ODE,STANDARD, restitution 1, ERP off
BOUNCING_BULLET = {
    1e-5: 7.52322, 4e-5: 120.372, 1e-4: 752.345, 4e-4: 12038.5, 1e-3: 75245.4, 4e-3: 1.20178e6, 1e-2: 7.40664e6,
    4e-2: 1.19223e8, 1e-1: 7.67704e8,
}  # fmt: skip
BOUNCING_ODE = {
    1e-5: 0.0185024, 4e-5: 0.296044, 1e-4: 1.85055, 4e-4: 29.631, 1e-3: 185.027, 4e-3: 2982.68, 1e-2: 18808.3,
    4e-2: 313419.0, 1e-1: 2.03326e6,
}  # fmt: skip
# step [s] -> (energy, angular momentum) relative to their start, largest over ten seconds, EnginesDtComplex
BOXES_ODE = {
    1e-4: (0.00124711, 0.0012715), 2e-4: (0.00249402, 0.0025506), 4e-4: (0.00498724, 0.00513209),
    5e-4: (0.00623355, 0.00643471), 8e-4: (0.00997124, 0.0103914), 1e-3: (0.012462, 0.0130708),
}  # fmt: skip
BOXES_BULLET = {
    1e-4: (0.0013586, 0.00125827), 2e-4: (0.002717, 0.00251355), 4e-4: (0.00543321, 0.00501523),
    5e-4: (0.00679101, 0.00626166), 8e-4: (0.0108632, 0.00998344), 1e-3: (0.0135771, 0.0124501),
}  # fmt: skip
BOXES_POSITION = {1e-4: 0.0049, 2e-4: 0.0098, 4e-4: 0.0196, 5e-4: 0.0245, 8e-4: 0.0392, 1e-3: 0.049}


@dataclass(frozen=True)
class Figure:
    """One published number and how to measure it here.

    Attributes
    ----------
    scenario : str
        Label in the catalogue, parameters included.
    engine : str
    settings : mapping
        Knobs of the run; ``dt`` is the step [s].
    quantity : str
        Name of the measured quantity.
    published : float or None
        None at a step for which nobody published a value.
    digits : int
        Significant digits to which the two must agree.
    published_for : str
        The engine it was published for.
    source : str
    theory : float or None
        What the time stepping alone must cost at this step, where a closed form is known.
    """

    scenario: str
    engine: str
    settings: Mapping[str, float | str]
    quantity: str
    published: float | None
    digits: int
    published_for: str
    source: str
    theory: float | None = None

    @property
    def dt(self) -> float:
        """Time step [s]."""
        return float(self.settings["dt"])


class Comparison(NamedTuple):
    """Ours beside the published value."""

    ours: float
    ratio: float  # ours / published; NaN where nothing is published
    agrees: bool | None  # within half a unit of the last of the figure's digits; None where nothing is published


@dataclass(frozen=True)
class Curve:
    """A published quantity over the step size, and an engine of ours that must lie on it."""

    family: str
    parameters: Mapping[str, object]
    engine: str
    knobs: Mapping[str, float | str]
    quantity: str
    values: Mapping[float, float]
    published_for: str
    source: str
    steps: tuple[float, ...]  # those checked by default
    theory: Callable[[float], float] | None = None
    digits: int = field(default=5)

    def at(self, dt: float) -> Figure:
        """The figure at the step `dt` [s]; `published` is None if nobody published one there."""
        known = next((v for step, v in self.values.items() if math.isclose(step, dt, rel_tol=1e-9)), None)
        return Figure(
            scenario=families()[self.family].of(dt=dt, **self.parameters).name,
            engine=self.engine,
            settings={"dt": dt, **self.knobs},
            quantity=self.quantity,
            published=known,
            digits=self.digits,
            published_for=self.published_for,
            source=self.source,
            theory=self.theory(dt) if self.theory else None,
        )


def _bouncing() -> Iterator[Curve]:
    theory = simbenchmark_bouncing.mean_square_theory
    for engine, layout, values, origin, closed in (
        ("pybullet:multibody", "grid", BOUNCING_BULLET, "Bullet", None),
        ("pybullet", "grid", BOUNCING_ODE, "ODE", theory),
        ("pymunk", "row", BOUNCING_ODE, "ODE", theory),
    ):
        yield Curve(
            "simbenchmark-bouncing", {"layout": layout}, engine, {}, "mean square energy error", values, origin,
            SIMBENCHMARK, (1e-3, 1e-2), closed,
        )  # fmt: skip


def _boxes() -> Iterator[Curve]:
    explicit, implicit = ("ODE", BOXES_ODE), ("Bullet", BOXES_BULLET)
    for engine, knobs, (origin, values) in (
        ("mujoco", {"integrator": "Euler"}, explicit),
        ("pybullet:multibody", {}, explicit),
        ("pybullet", {}, implicit),
        ("mujoco", {"integrator": "implicitfast"}, implicit),
    ):
        for quantity, numbers, digits, theory in (
            ("relative energy error", {h: v[0] for h, v in values.items()}, 5, None),
            (
                "relative angular momentum error",
                {h: v[1] for h, v in values.items()},
                4 if origin == "ODE" else 5,
                None,
            ),
            ("position error", BOXES_POSITION, 5, gazebo_boxes.position_theory),
        ):
            yield Curve(
                "gazebo-boxes", {}, engine, knobs, quantity, numbers, origin, GAZEBO, (1e-3,), theory, digits
            )  # fmt: skip


CURVES: tuple[Curve, ...] = (*_bouncing(), *_boxes())
"""Every published curve with the engine of ours that must lie on it."""


def figures(steps: Sequence[float] | None = None) -> tuple[Figure, ...]:
    """Published figures at the steps checked by default, or at every step [s] of `steps`.

    Raises
    ------
    ValueError
        For a step that the scenario does not allow.
    """
    return tuple(curve.at(dt) for curve in CURVES for dt in (curve.steps if steps is None else steps))


def compare(figure: Figure, measured: float) -> Comparison:
    """Our measured value beside the published one."""
    if figure.published is None:
        return Comparison(measured, math.nan, None)
    unit = 10.0 ** (math.floor(math.log10(abs(figure.published))) - figure.digits + 1)
    agrees = abs(measured - figure.published) <= 0.5 * unit
    return Comparison(measured, measured / figure.published, agrees)
