"""The public names, for type checkers; `__init__.py` imports them when they are used."""

from adapters.conformance import check_engine
from adapters.engine import ContactForce, Engine, Impact, Refusal
from adapters.registry import NotInstalled, Unavailable
from adapters.run import Failure, Run
from mechanics.arrays import SceneError
from mechanics.effects import (
    Drag,
    Effect,
    Force,
    Friction,
    Gravity,
    Hinge,
    Resting,
    Restitution,
    Rod,
    Rotation,
    Spring,
    Tether,
)
from mechanics.scene import Body, Scene
from mechanics.scene_file import load_scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from mechanics.trajectory import State, Trajectory
from plumbline.api import run, simulate
from plumbline.results import Results
from scenarios.catalogue import UnknownName
from scenarios.scenario import Check, Scenario, scenario

__version__: str

__all__ = [
    "Body",
    "Box",
    "Capsule",
    "Check",
    "ContactForce",
    "Cylinder",
    "Drag",
    "Effect",
    "Engine",
    "Failure",
    "Force",
    "Friction",
    "Gravity",
    "HalfSpace",
    "Hinge",
    "Impact",
    "Mesh",
    "NotInstalled",
    "Refusal",
    "Resting",
    "Restitution",
    "Results",
    "Rod",
    "Rotation",
    "Run",
    "Scenario",
    "Scene",
    "SceneError",
    "Sphere",
    "Spring",
    "State",
    "Tether",
    "Trajectory",
    "Unavailable",
    "UnknownName",
    "check_engine",
    "load_scene",
    "run",
    "scenario",
    "simulate",
]
