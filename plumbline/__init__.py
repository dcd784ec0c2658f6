"""Plumbline: validation and benchmarking of rigid-body physics engines.

    from plumbline import Body, Gravity, Scene, Sphere, simulate

    scene = Scene((Body("ball", Sphere(0.1), mass=1.0),), (Gravity(),))
    run = simulate(scene, engine="mujoco", times=[0.0, 0.5, 1.0])
    run.outcome.x  # positions, (3, 1, 3) [m]

Names are imported when they are first used, so `import plumbline` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

_HOMES = {
    "adapters.conformance": ("check_engine",),
    "adapters.engine": ("ContactForce", "Engine", "Impact", "Refusal"),
    "adapters.registry": ("NotInstalled", "Unavailable"),
    "adapters.run": ("Failure", "Run"),
    "mechanics.arrays": ("SceneError",),
    "mechanics.effects": ("Drag", "Effect", "Force", "Friction", "Gravity", "Hinge", "Resting", "Restitution", "Rod",
                          "Rotation", "Spring", "Tether"),
    "mechanics.scene": ("Body", "Scene"),
    "mechanics.scene_file": ("load_scene",),
    "mechanics.shapes": ("Box", "Capsule", "Cylinder", "HalfSpace", "Mesh", "Sphere"),
    "mechanics.trajectory": ("State", "Trajectory"),
    "plumbline.api": ("run", "simulate"),
    "plumbline.results": ("Results",),
    "scenarios.catalogue": ("UnknownName",),
    "scenarios.scenario": ("Check", "Scenario", "scenario"),
}  # fmt: skip
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("plumbline")
    if name not in _HOME:
        raise AttributeError(f"module 'plumbline' has no attribute {name!r}; it has {', '.join(__all__)}")
    value = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
