"""Bounces in the compiled loop: as the general algorithm has them, conserved quantities, reversal, degenerate cases."""

import math

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Restitution, Rotation
from mechanics.rotation import normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from reference_impl.simulate import advance, begin
from reference_impl.world import Settings


def room(side):
    """Six walls around the cube from 0 to `side`."""
    walls = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal, place = np.zeros(3), np.zeros(3)
            normal[axis], place[axis] = sign, 0.0 if sign > 0.0 else side
            walls.append(Body(f"wall {axis} {sign}", HalfSpace(tuple(normal)), position=tuple(place)))
    return tuple(walls)


def balls(n, seed, side, radii=(0.04, 0.08), speed=1.0, spin=0.0, masses=(1.0, 1.0)):
    """n spheres on the sites of a grid, with random velocities."""
    rng, count = np.random.default_rng(seed), math.ceil(n ** (1 / 3))
    sites = np.array([(i, j, k) for i in range(count) for j in range(count) for k in range(count)])
    pitch, out = side / count, []
    for number, site in enumerate(rng.permutation(sites)[:n]):
        radius = rng.uniform(*radii)
        place = (site + 0.5) * pitch + (0.49 * pitch - radius) * rng.uniform(-1.0, 1.0, 3)
        out.append(
            Body(f"ball {number}", Sphere(radius), rng.uniform(*masses), tuple(place),
                 velocity=tuple(speed * rng.normal(size=3)), angular_velocity=tuple(spin * rng.normal(size=3)),
                 orientation=tuple(normalised(rng.normal(size=4))))
        )  # fmt: skip
    return tuple(out)


def both(scene, duration, **settings):
    """Worlds after `duration`, with the loop and without."""
    with_loop, without = begin(scene, Settings(**settings)), begin(scene, Settings(**settings))
    assert with_loop.flock is not None
    without.flock = None
    for world in (with_loop, without):
        advance(world, duration)
    return with_loop, without


def assert_same(with_loop, without, tolerance):
    assert [(e.a, e.b) for e in with_loop.events] == [(e.a, e.b) for e in without.events]
    for one, other in zip(with_loop.events, without.events, strict=True):
        assert one.time == pytest.approx(other.time, abs=tolerance)
        assert one.impulse == pytest.approx(other.impulse, abs=tolerance)
        assert one.point == pytest.approx(other.point, abs=tolerance)
        assert one.normal == pytest.approx(other.normal, abs=tolerance)
    one, other = with_loop.state(), without.state()
    for name in ("x", "q", "v", "w"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), abs=tolerance), name
    assert with_loop.audit.events == without.audit.events
    assert with_loop.audit.impacts == without.audit.impacts


@pytest.mark.parametrize("seed", range(8))
def test_the_loop_gives_the_events_of_the_general_algorithm(seed):
    """Smooth and rough spheres of different mass and size, turning or not, with and without gravity, all e."""
    rng = np.random.default_rng(seed)
    effects = [Restitution(float(rng.uniform(0.5, 1.0)), {("ball 0", "ball 1"): 0.2, ("ball 2", "wall 0 1.0"): 0.6})]
    if seed % 2:
        effects.append(Gravity())
    if seed % 4 > 1:
        effects.append(Rotation())
    if seed > 3:
        effects.append(Friction(0.3, {("ball 3", "ball 4"): 0.0}))
    n = 6 if seed % 3 else 30  # without and with cells
    side = 1.0 if n == 6 else 1.4
    spin = 5.0 if Rotation() in effects else 0.0
    scene = Scene((*room(side), *balls(n, seed, side, spin=spin, masses=(0.5, 5.0))), tuple(effects))
    with_loop, without = both(scene, 0.8 if n == 6 else 0.25)
    assert len(with_loop.events) > 8
    # what differs in the last digit grows by v/r times the free path at each collision; few have happened
    assert_same(with_loop, without, 1e-10)
