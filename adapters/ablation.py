"""Engines between stock and fair, one setting apart from either: what each setting is worth.

`pybullet:stock+damping` is the stock profile with that one setting of the fair one, `pybullet:fair-damping` is the
fair profile without it.  They are made for ablations only (`plumbline ablate`) and are on no list of engines.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from adapters import mujoco, pybullet, pymunk
from adapters.configured import Configured
from adapters.engine import Knob

# setting, by the name that the adapter asks for -> how the profile begins that gives the reason; knobs besides
SETTINGS: Mapping[str, Mapping[str, str]] = {
    "mujoco": {
        "cone": "cone",
        "contact": "solref = 0",
        "diagexact": "diagexact",
        "inertia": "explicit inertia",
        "links": "solref = 0",
    },
    "pybullet": {
        "useMaximalCoordinates": "useMaximalCoordinates",
        "restitutionVelocityThreshold": "restitutionVelocityThreshold",
        "contactSlop": "contactSlop",
        "contactProcessingThreshold": "contactProcessingThreshold",
        "damping": "linearDamping",
        "solverResidualThreshold": "solverResidualThreshold",
        "useSplitImpulse": "useSplitImpulse",
        "contactERP": "contactERP",
        "inertia": "inertia",
        "collisionMargin": "collisionMargin",
        "half-space": "half-space",
    },
    "pymunk": {
        "collision_slop": "collision_slop",
        "collision_bias": "collision_bias",
        "error_bias": "error_bias",
        "moments": "moments",
    },
}
# what a knob is that the stock profile leaves to the engine
LEFT_ALONE: Mapping[str, float] = {"substeps": 1.0, "tolerance": 1e-8}
LIBRARIES: Mapping[str, Mapping[str, Configured]] = {
    "mujoco": mujoco.ENGINES,
    "pybullet": pybullet.ENGINES,
    "pymunk": pymunk.ENGINES,
}


def settings(library: str) -> dict[str, str]:
    """Every setting in which the fair profile of a library departs from its stock profile -> the reason."""
    stock, fair = _profiles(library)
    told = {
        name: next(why for said, why in fair.profile.items() if said.startswith(start))
        for name, start in SETTINGS[library].items()
    }
    usual = _usual(stock, fair)
    turned = {name: f"{_told(usual[name])} in stock, {_told(value)} in the fair profile"
              for name, value in fair.defaults.items() if value != usual[name]}  # fmt: skip
    return told | turned


def with_one(library: str, setting: str) -> Configured:
    """The stock profile with one setting of the fair one."""
    return between(library, f"stock+{setting}", {setting})


def without_one(library: str, setting: str) -> Configured:
    """The fair profile with one setting of the stock one."""
    return between(library, f"fair-{setting}", set(settings(library)) - {setting})


def between(library: str, profile: str, on: Collection[str]) -> Configured:
    """The profile with exactly the settings in `on` as the fair profile has them: none is stock, all are fair."""
    stock, fair = _profiles(library)
    told: dict[str, Any] = {"maximal": "useMaximalCoordinates" in on} if library == "pybullet" else {}
    usual = _usual(stock, fair)
    return replace(
        stock,
        name=f"{library}:{profile}",
        knobs=fair.knobs,
        defaults={knob: fair.defaults[knob] if knob in on else value for knob, value in usual.items()},
        departures=frozenset(on),
        known={},
        on_request=True,
        **told,
    )


def _profiles(library: str) -> tuple[Configured, Configured]:
    return LIBRARIES[library][f"{library}:stock"], LIBRARIES[library][library]


def _usual(stock: Configured, fair: Configured) -> dict[str, Knob]:
    """Knobs of the fair profile with the values they have in stock."""
    return {name: stock.defaults.get(name, LEFT_ALONE.get(name, value)) for name, value in fair.defaults.items()}


def _told(value: Knob) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


ENGINES: Mapping[str, Configured] = {
    engine.name: engine
    for library in LIBRARIES
    for setting in settings(library)
    for engine in (with_one(library, setting), without_one(library, setting))
}
