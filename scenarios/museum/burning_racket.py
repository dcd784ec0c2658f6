"""Exhibits 4 and 5: a box that turns freely, its energy over half a minute, and a change between two versions."""

from __future__ import annotations

from mechanics.effects import Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from scenarios.exhibit import Exhibit, Remedy
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tumbling_box import tumbling

SIZE = (1.0, 0.5, 0.1)  # [m]; moments 0.26, 1.01 and 1.25 over 12 [kg m2]
SPINS = {"middle": (1e-3, 6.0, 0.0), "largest": (0.5, 0.0, 6.0)}  # [rad/s]
RK4 = Remedy("mujoco:stock", "integrator = RK4", "MuJoCo documentation, Computation: Numerical integration",
             {"integrator": "RK4"})  # fmt: skip
UNDAMPED = Remedy(
    "pybullet:undamped", "linearDamping = angularDamping = 0", "PyBullet Quickstart Guide, changeDynamics"
)
IMPLICIT = tuple(
    Remedy(
        "mujoco:stock", "integrator = implicitfast", "MuJoCo changelog, 3.11.0", {"integrator": "implicitfast", "dt": h}
    )
    for h in (2e-3, 1e-2)
)
RACKET = Exhibit(
    number=4,
    title="The racket that burns",
    shown="A box turns freely about one of its axes.  It turns over about when it should and looks right; but a "
    "gyroscopic term that is stepped explicitly puts energy in, and one stepped implicitly takes it out.",
    truth="Nothing acts: energy and angular momentum stay what they are.",
    figures={"energy kept": 1.0, "angular momentum error": 0.0},
    origin=(
        "https://github.com/bulletphysics/bullet3/pull/346",
        "https://github.com/avianphysics/avian/pull/420",
        "https://github.com/godotengine/godot/issues/50173",
    ),
    remedies=(RK4, UNDAMPED),
)
UPGRADE = Exhibit(
    number=5,
    title="The upgrade",
    shown="The same box, and nothing but the version changes: MuJoCo 3.11.0 replaced the midpoint rule of free bodies "
    "under implicitfast, as its changelog says.  One environment holds one version: docs/museum.md says how to see "
    "both.  A baseline tied to versions is what catches such a change.",
    truth="Nothing acts: the energy stays what it is.",
    figures={"energy kept": 1.0},
    origin=("https://mujoco.readthedocs.io/en/3.11.0/changelog.html", "https://github.com/dimforge/rapier/issues/974"),
    remedies=(*IMPLICIT, RK4),
)


def _box(axis: str, exhibit: Exhibit) -> Scenario:
    scene = Scene((Body("box", Box(SIZE), 1.0, angular_velocity=SPINS[axis]),), (Rotation(),))
    why = "one per cent in half a minute tells integrators that keep it from those that drift by ten and more"
    return Scenario(
        scene=scene,
        duration=30.0,
        sampling=0.1,
        truth=tumbling(scene),
        checks=(
            Check("energy error", 0.01, why),
            Check("angular momentum error", 0.01, why),
        ),
        source="Landau and Lifshitz, Mechanics, §37",
        about=(Rotation,),
        exhibit=exhibit,
    )


@scenario(
    tags=("museum", "rotation"),
    suites=("museum",),
    variants=({}, {"axis": "largest"}),
    ranges={"axis": ("middle", "largest")},
)
def burning_racket(axis: str = "middle") -> Scenario:
    """A box turns freely for half a minute, about its middle axis or, with a wobble, about its largest.

    About the middle axis it turns over eight times (Dzhanibekov); about the largest it only wobbles.  Either way
    its kinetic energy is constant, which no picture of it shows.
    """
    return _box(axis, RACKET)


@scenario(tags=("museum", "rotation"), suites=("museum",))
def upgraded_tumble() -> Scenario:
    """A box turns freely for half a minute; its energy is to be the same in every version of an engine.

    Run it in two environments that differ in the version of one engine, and compare.
    """
    return _box("middle", UPGRADE)
