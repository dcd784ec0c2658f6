"""Engines of the tests: one that is right and small, and one that breaks as it is told to.

`toy` moves bodies under gravity along parabolas, in steps of `dt` with the speed at the middle of
the step, which is exact for uniform gravity.  `toy:faulty` does the same until t = 0.5 s and then
does what its knob `fault` says.
"""

import ctypes
import os
import signal
import time
from types import SimpleNamespace

import numpy as np

from adapters.engine import Clock, Impact, Refusal
from mechanics.effects import Force, Gravity, Rotation
from mechanics.trajectory import State

FAULTS = ("none", "segv", "abort", "hang", "oom", "bad_alloc", "raise", "nan", "print", "exit", "unsendable", "kill")
BREAKS_AT = 0.5  # [s]


class Toy:
    """Free flight; `name:slow` and others differ in the name only."""

    version = "1.2.3"

    def __init__(self, name="toy"):
        self.name = name
        self.knobs = {"dt": (0.1, 0.05, 0.025)}
        self.defaults = {"dt": 0.05}
        self.profile = {"dt": "long steps, because the parabola is exact at any length"}
        self.effects = {Gravity: self.gravity, Rotation: lambda draft, effect: "rotation is read, not integrated"}

    @staticmethod
    def gravity(draft, effect):
        draft.g = np.array(effect.acceleration)

    def vacuum(self, scene):
        s = scene.start()
        free = np.array([not b.fixed for b in scene.bodies])[:, None]
        return SimpleNamespace(x=s.x.copy(), q=s.q.copy(), v=s.v.copy(), w=s.w.copy(), g=np.zeros(3), free=free)

    def start(self, draft, knobs):
        draft.clock = Clock(knobs["dt"])
        draft.knobs = dict(knobs)
        return draft

    def advance(self, world, duration):
        for _ in range(world.clock.steps(duration)):
            dv = world.free * world.g * world.clock.dt
            world.x = world.x + (world.v + dv / 2) * world.clock.dt
            world.v = world.v + dv

    def read(self, world):
        return State(world.clock.time, world.x.copy(), world.q.copy(), world.v.copy(), world.w.copy())

    def events(self, world):
        return [Impact(0.25, "a", "b", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), np.float64(2.0))]

    def audit(self, world):
        return {"steps": np.int64(world.clock.count)}


class Faulty(Toy):
    """Breaks in `advance` once t = 0.5 s is reached."""

    def __init__(self, name):
        super().__init__(name)
        self.knobs = {"dt": (0.1, 0.05), "fault": FAULTS}
        self.defaults = {"dt": 0.05, "fault": "none"}

    def advance(self, world, duration):
        super().advance(world, duration)
        if world.clock.time > BREAKS_AT:
            getattr(self, world.knobs["fault"])(world)

    def events(self, world):
        return [lambda: None] if world.knobs["fault"] == "unsendable" else []

    def none(self, world):
        """Go on."""

    unsendable = none

    def segv(self, world):
        ctypes.string_at(0)

    def abort(self, world):
        os.write(2, b"solver: assertion failed, giving up\n")
        os.abort()

    def hang(self, world):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        while True:
            time.sleep(1.0)

    def oom(self, world):
        world.hoard = np.ones(1 << 40)

    def bad_alloc(self, world):
        os.write(2, b"terminate called after throwing an instance of 'std::bad_alloc'\n")
        os.abort()

    def exit(self, world):
        os._exit(3)

    def kill(self, world):
        os.kill(os.getpid(), signal.SIGKILL)

    def nan(self, world):
        world.v[:] = np.nan

    def print(self, world):
        print("python speaks")
        ctypes.CDLL(None).puts(b"C speaks")
        os.write(2, b"the descriptor speaks\n")

    def __getattribute__(self, name):
        return super().__getattribute__("throw" if name == "raise" else name)

    def throw(self, world):
        raise ArithmeticError("the solver has met a singular matrix")


class Shy(Toy):
    """Refuses Force with its own reason."""

    def __init__(self, name):
        super().__init__(name)
        self.effects = {**self.effects, Force: self.refuse}

    @staticmethod
    def refuse(draft, effect):
        raise Refusal("forces hurt")


ENGINES = {engine.name: engine for engine in (Toy(), Faulty("toy:faulty"), Shy("toy:shy"))}
