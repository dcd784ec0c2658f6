"""A campaign made up so that every state, profile and kind of text occurs; no engine runs."""

from __future__ import annotations

import math
import os
import shutil
from dataclasses import replace

import numpy as np
import pytest

from adapters.run import Failure, Run
from comparisons.cell import STATES, Campaign, Cell, cell_key
from comparisons.measurement import Measurement
from mechanics.effects import Gravity, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.scenario import Check, Scenario

ENGINES = {
    "reference": "0.1.0",
    "mujoco": "4.0.1",
    "pybullet": "3.2.7",
    "pymunk": "7.3.1",
    "mujoco:stock": "4.0.1",
    "pybullet:stock": "3.2.7",
    "pymunk:stock": "7.3.1",
}
# label -> deciding quantity, unit, tolerance, why, and error / tolerance (or a state) of each engine
SCENES = {
    "free-fall": ("position error", "m", 0.0074, "g t h/2", (1e-13, 0.67, 0.67, 0.66, 0.67, 0.67, 0.66)),
    "bouncing-ball": ("position error", "m", 0.021, "one step late", (3e-12, 0.42, 0.55, 0.31, 14.2, 9.9, 1.8)),
    "bouncing-ball[e=0.3]": ("restitution error", "1", 0.02, "known to g h", (0, 0.4, 0.31, 0.2, 33.4, "xfail", 0.8)),
    "torque-free-tumbling": ("orientation error", "rad", 0.01, "first order", (2e-9, 0.02, 1.31, "refused", 0.9, 1.3,
                             "refused")),
    "newtons-cradle[balls=5]": ("velocity error", "m/s", 0.05, "gap", (1e-10, 0.3, "xfail", 0.7, 12.0, "diverged",
                                1.2)),
    "sliding-block": ("distance error", "m", 0.003, "v h/2", ("refused", 0.61, 0.2, 0.33, 4.1, 0.4, 0.6)),
    "resting-stack[n=10]": ("penetration", "m", 0.001, "v h", (0.02, 0.8, 1.3, 0.9, 7.7, "timeout", "xpass")),
    "ten-boxes-dropped": ("energy rise", "1", 1e-3, "may only fall", ("error", 0.75, 0.38, "refused", 3.0, "crash",
                          "refused")),
    "cradle-touching": ("impact law", "", math.nan, "", ("open",) * 7),
}  # fmt: skip
REASONS = {
    "refused": "the scene is not planar: body 'box': velocity (1.0, 0.5, 0.0) is not in the x-z plane",
    "diverged": "the state holds NaN or infinity",
    "timeout": "killed after 60 s",
    "crash": "the process died of signal 11 (SIGSEGV)",
    "error": "ValueError: no vertices (hull, line 41)",
    "not-installed": "pip install pymunk",
    "not-run": "the budget of 60 s was spent",
    "oom": "out of memory",
}
STAGE = {"diverged": "advance", "timeout": "advance", "crash": "start", "error": "build", "refused": "build"}


def _row(quantity: str, value: float, unit: str, tolerance: float = math.nan, why: str = "", **more) -> Measurement:
    if math.isnan(tolerance):
        verdict = "info"
    else:
        verdict = "exact" if value <= 1e-7 * tolerance else "ok" if value <= tolerance else "fail"
    whole = {"time": 0.8, "text": "", "exact": 1e-9} | more
    return Measurement(quantity, value, unit, tolerance=tolerance, why=why, verdict=verdict, **whole)


def _measurements(scene: str, outcome: float | str, place: int) -> tuple[Measurement, ...]:
    quantity, unit, tolerance, why, _ = SCENES[scene]
    if outcome == "open":
        return (_row(quantity, math.nan, "", text="sequential" if place % 2 else "simultaneous"),)
    if isinstance(outcome, str) and outcome not in ("xfail", "xpass"):
        return ()
    share = {"xfail": 5.5, "xpass": 0.9}.get(outcome, outcome)
    small = 1e-14 * (1 + place) if place == 0 else 10.0 ** (place - 9)
    return (
        _row(quantity, share * tolerance, unit, tolerance, why),
        _row("energy error", 40 * small, "1"),
        _row("energy error, synchronised", small, "1", 1e-2, "first order"),
        _row("linear momentum error", small / 7, "1"),
        _row("restitution", 0.8 - small, "1", text=f"asked 0.8, got {0.8 - small:.4g}"),
        _row("angular momentum error", math.nan, "1", text="gravity has a moment about every point at rest"),
    )


def _cell(scene: str, engine: str, outcome: float | str, place: int) -> Cell:
    state = outcome if outcome in STATES else "ok" if outcome == "open" or outcome <= 1.0 else "fail"
    settings = {"dt": 0.001} | ({"iterations": 200.0} if engine.startswith("pybullet") else {})
    cost = math.nan if state in REASONS else 1e-3 * (1 + len(scene)) / 9 * (1 + place) ** 1.4
    version = ENGINES[engine]
    noted = (scene, engine) == ("bouncing-ball", "mujoco")
    return Cell(
        key=cell_key(scene, 1, engine, version, settings),
        scenario=scene,
        family=scene.partition("[")[0],
        version=1,
        tags=("impact",),
        engine=engine,
        engine_version=version,
        settings=settings,
        state=state,
        duration=2.0,
        stage=STAGE.get(state, ""),
        reason=REASONS.get(state, ""),
        time=1.234 if state in ("diverged", "timeout") else 0.0 if state in REASONS else 2.0,
        measurements=_measurements(scene, outcome, place),
        cost=cost,
        repeats=5,
        contention=0.31 if place == 2 else 0.04,
        build_seconds=0.004,
        digest=f"{place:032x}",
        impacts=3 if place < 2 else -1,
        notes=("Restitution by a one-step contact of zero compliance.",) if noted else (),
        known="split impulse forgets the second of two simultaneous impacts" if state.startswith("x") else "",
        output="b3Warning: unphysical" if state == "crash" else "",
        trace=f"traces/{engine}.npz",
        reproduce=f"plumbline run -s '{scene}' -e {engine} --set dt=0.001",
    )


@pytest.fixture(scope="session")
def campaign() -> Campaign:
    """Nine scenarios in seven engines."""
    cells = [
        _cell(scene, engine, outcome, place)
        for scene, told in SCENES.items()
        for place, (engine, outcome) in enumerate(zip(ENGINES, told[4], strict=True))
    ]
    described = {
        scene: {
            "summary": f"What {scene} is about, in a sentence.",
            "source": "Goldstein, Classical Mechanics, 3rd ed., §1.1",
            "tags": ["impact"],
            "effects": ["Gravity", "Restitution"],
            "checks": [] if math.isnan(t[2]) else [
                {"quantity": t[0], "tolerance": t[2], "why": t[3], "exact": 1e-9},
                {"quantity": "energy error, synchronised", "tolerance": 0.01, "why": "first order", "exact": 1e-9},
            ],
        }
        for scene, t in SCENES.items()
    }  # fmt: skip
    profiles = {"mujoco": {"solref": "one-step contact: restitution is exact for every step"}}
    engines = {
        e: {"version": v, "settings": dict(next(c.settings for c in cells if c.engine == e)),
            "profile": profiles.get(e, {})}
        for e, v in ENGINES.items()
    }  # fmt: skip
    fingerprint = {"machine": "x86_64, 2 cores", "python": "3.11.2", "packages": {"numpy": "2.3.1", "scipy": "1.16.0"}}
    return Campaign("20261121T101500Z-standard", "standard suite", "plumbline run standard", "2026-11-21T10:15:00Z",
                    83.4, fingerprint, described, engines, tuple(cells))  # fmt: skip


@pytest.fixture(scope="session")
def every_state(campaign: Campaign) -> Campaign:
    """One cell in each state of the vocabulary."""
    model = campaign.cells[0]
    cells = [replace(model, key=f"{n:016x}", scenario=f"s-{state}", state=state, reason=REASONS.get(state, ""))
             for n, state in enumerate(STATES)]  # fmt: skip
    return replace(campaign, cells=tuple(cells))


def _fall(t: np.ndarray, dt: float) -> Trajectory:
    """A ball in free fall from 3 m beside a floor; semi-implicit Euler of step dt, or exact for dt = 0."""
    x, v = np.zeros((len(t), 2, 3)), np.zeros((len(t), 2, 3))
    x[:, 1, 2] = 3.0 - 0.5 * 9.81 * t * (t + dt)
    v[:, 1, 2] = -9.81 * t
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 2, 1))
    return Trajectory(t, x, q, v, np.zeros_like(x))


@pytest.fixture(scope="session")
def falling() -> Scenario:
    """The scenario that the recorded motions belong to."""
    bodies = (Body("floor", HalfSpace()), Body("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.0, 3.0)))
    scene = Scene(bodies, (Gravity(), Restitution(0.8)))
    check = Check("position error", 0.0074, "g t h/2")
    return Scenario(scene, 0.7, 0.001, (check,), "Galilei", truth=lambda t: _fall(t, 0.0), name="free-fall")


@pytest.fixture(scope="session")
def traces(campaign: Campaign) -> dict[str, Trajectory | Run]:
    """Motions of free-fall: bare for the reference, as runs with a lead for the others."""
    t = np.arange(701) * 1e-3
    found: dict[str, Trajectory | Run] = {}
    for cell in campaign.cells:
        if cell.scenario == "free-fall":
            dt = 0.0 if cell.engine == "reference" else 2e-2
            motion = _fall(t, dt)
            blank = Failure("error", "build", 0.0, "")
            run = Run(cell.engine, cell.engine_version, dict(cell.settings), blank, partial=motion, lead=dt / 2)
            found[cell.key] = motion if dt == 0.0 else run
    return found


@pytest.fixture(scope="session")
def hostile(campaign: Campaign) -> Campaign:
    """The campaign with markup, control characters and surrogates wherever a text may come from outside."""
    evil = "<script>alert(1)</script>\"'&<img src=x onerror=alert(2)>|`*_\x00\x1b[31m\ud800￾"
    cells = [
        replace(c, scenario=evil + c.scenario, reason=evil, notes=(evil,), output=evil, reproduce=evil, known=evil,
                engine=f"{c.engine}</style><b>", key=f"\"><b>{n}", settings={"dt": 1e-3, evil: evil},
                measurements=tuple(replace(m, quantity=evil, text=evil, why=evil, unit=evil) for m in c.measurements))
        for n, c in enumerate(campaign.cells)
    ]  # fmt: skip
    told = {evil + k: {**v, "summary": evil, "source": evil} for k, v in campaign.scenarios.items()}
    return replace(
        campaign, title=evil, command=evil, id=evil, cells=tuple(cells), scenarios=told, fingerprint={evil: evil}
    )


FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@pytest.fixture(scope="session")
def chromium_launch():
    """Starts a headless Chromium, driven by playwright; tests that need one are skipped by name where there is none."""
    api = pytest.importorskip("playwright.sync_api")
    path = os.environ.get("REPORT_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    if not path:
        pytest.skip("no Chromium on this machine (set REPORT_CHROMIUM to its path)")
    with api.sync_playwright() as playwright:
        yield lambda flags: playwright.chromium.launch(executable_path=path, headless=True, args=list(flags))


@pytest.fixture(scope="session")
def chromium(chromium_launch):
    """A headless Chromium with WebGL in software."""
    browser = chromium_launch(FLAGS)
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def chromium_without_webgl(chromium_launch):
    """A headless Chromium that has no WebGL at all."""
    browser = chromium_launch([*(f for f in FLAGS if "gl" not in f and "swiftshader" not in f), "--disable-3d-apis"])
    yield browser
    browser.close()
