"""Mechanical energy: translation, rotation with the house's inertia, gravity, springs, constant forces.

Energy that a soft contact stores is not counted: where contact is rigid there is none.

Time levels.  An engine that moves with the new velocity reports positions that run ahead of its
velocities by `lead` = h/2 (see `adapters.engine.lead`), so the sum of kinetic and potential energy
oscillates by m g v h/2 without drifting.  *Synchronised* energy takes the potential at x - lead v, the
place that belongs to the velocity: constant to rounding for a semi-implicit Euler in free fall.
Rotational energy keeps the attitude as reported, because such engines turn ω and attitude together.

Scale.  Errors are relative to the energy the scene has to spend: the mechanical energy at the start
above the lowest potential of the run, K(0) + U(0) - min U, in free fall the kinetic energy at the
lowest point.  An engine that gains energy does not enlarge its own scale.  It is at least Σ m a r,
what lifts every body by its radius against gravity and constant forces, so that bodies at rest are
not measured against nothing.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.measurement import Case, Quantity
from comparisons.moving import Moving
from mechanics.effects import Force, Spring
from mechanics.rotation import rotate
from mechanics.scene import Scene
from mechanics.trajectory import Trajectory

QUANTITIES = {
    "energy error": ("1", "largest |E - E(0)| over the energy the scene has to spend, from the states as reported"),
    "energy error, synchronised": ("1", "the same with positions carried back to the time of the velocities"),
    "energy rise": ("1", "largest rise of energy above any earlier value where it may only fall, over the same scale"),
    "energy rise, synchronised": ("1", "the same with positions carried back to the time of the velocities"),
    "energy kept": ("1", "1 + (E(end) - E(0)) over the energy the scene has to spend"),
    "mean square energy error": ("J2", "mean of (E - E(0))² over all samples but the last (as in SimBenchmark)"),
    "relative energy error": (
        "1",
        "largest |E - E(0)| / |E(0)|, potential 0 at z = 0 (as in the Gazebo boxes benchmark)",
    ),
}


def measure(case: Case) -> Iterator[Quantity]:
    """The energy errors of a case, as far as the scene says anything about its energy."""
    moving = case.moving
    if not len(moving.mass):
        return
    law = case.conserved
    if law.energy == "unknown":
        asked = (name for name in QUANTITIES if case.asks(name))
        yield from (Quantity(name, np.nan, QUANTITIES[name][0], text=law.sentences()[2]) for name in asked)
        return
    duration = case.scenario.duration
    potential = potential_energy(moving, case.trajectory, until=duration)
    raw = moving.kinetic + potential
    synchronised = moving.kinetic + potential_energy(moving, case.trajectory, case.run.lead, duration)
    scale = energy_scale(moving, potential)
    for energy, suffix in ((raw, ""), (synchronised, ", synchronised")):
        if law.energy == "conserved":
            yield Quantity.worst(f"energy error{suffix}", np.abs(energy - energy[0]), "1", moving.t, scale)
        else:
            rise = energy - np.minimum.accumulate(energy)
            yield Quantity.worst(f"energy rise{suffix}", rise, "1", moving.t, scale)
    kept = 1.0 + float(synchronised[-1] - synchronised[0]) / scale if scale else np.nan
    yield Quantity("energy kept", kept, "1", float(moving.t[-1]))
    if case.asks("mean square energy error"):
        yield Quantity("mean square energy error", mean_square_error(raw), "J2")
    if case.asks("relative energy error"):
        yield Quantity.worst("relative energy error", np.abs(raw - raw[0]), "1", moving.t, abs(float(raw[0])))


def mechanical_energy(scene: Scene, trajectory: Trajectory, lead: float = 0.0, until: float = np.inf) -> np.ndarray:
    """(T,) kinetic plus potential energy of the moving bodies [J]; arguments as in `potential_energy`."""
    moving = Moving.of(scene, trajectory)
    return np.asarray(moving.kinetic + potential_energy(moving, trajectory, lead, until))


def potential_energy(moving: Moving, trajectory: Trajectory, lead: float = 0.0, until: float = np.inf) -> np.ndarray:
    """Energy of the moving bodies in gravity, springs and constant forces at every sample [J].

    Parameters
    ----------
    moving : Moving
    trajectory : Trajectory
        Of all bodies of the scene: springs may end on fixed ones.
    lead : float
        Time by which positions run ahead of velocities [s].
    until : float
        Duration of the scenario [s]: a constant force has a potential if it acts throughout it.

    Returns
    -------
    (T,) array.  Gravity's potential is 0 at the world's origin, that of a constant force likewise.
    """
    scene = moving.scene
    weighted = moving.mass.sum() * moving.centre - lead * moving.momentum
    potential = -(weighted @ scene.gravity)
    for force in scene.all(Force):
        if force.start == 0.0 and force.end >= until:
            point = _anchor(scene, trajectory, force.body, force.point, lead)
            potential -= point @ np.array(force.force)
    for spring in scene.all(Spring):
        a = _anchor(scene, trajectory, spring.a, spring.anchor_a, lead)
        b = _anchor(scene, trajectory, spring.b, spring.anchor_b, lead)
        potential += 0.5 * spring.stiffness * (np.linalg.norm(a - b, axis=1) - spring.length) ** 2
    return np.asarray(potential)


def energy_scale(moving: Moving, potential: np.ndarray) -> float:
    """Energy the scene has to spend: K(0) + U(0) - min U, at least Σ m a r; the largest K if all that is 0 [J]."""
    spendable = float(moving.kinetic[0] + potential[0] - potential.min())
    lifted = float((moving.mass * moving.pull) @ moving.radius)
    return max(spendable, lifted) or float(moving.kinetic.max())


def mean_square_error(energy: np.ndarray) -> float:
    """Mean of (E - E(0))² over all samples but the last [J2]: SimBenchmark samples before each step."""
    sampled = energy[:-1] if len(energy) > 1 else energy
    return float(np.mean((sampled - sampled[0]) ** 2))


def _anchor(scene: Scene, trajectory: Trajectory, body: str, anchor: tuple[float, ...], lead: float) -> np.ndarray:
    """(T, 3) world positions of a point of a body, carried back by `lead` [m]."""
    i = scene.index(body)
    arm = rotate(trajectory.q[:, i], np.array(anchor))
    return np.asarray(trajectory.x[:, i] + arm - lead * (trajectory.v[:, i] + np.cross(trajectory.w[:, i], arm)))
