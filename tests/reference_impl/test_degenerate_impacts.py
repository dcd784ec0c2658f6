"""Degenerate impacts: bounces that accumulate, and what happens where impulses are not unique."""

import math

import numpy as np
import pytest

from mechanics.effects import Drag, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin
from reference_impl.world import STILL

FLOOR = Body("floor", HalfSpace())


def ball(height, radius=0.1, **told):
    return Body("ball", Sphere(radius), 1.0, (0.0, 0.0, height + radius), **told)


@pytest.mark.parametrize("law", ["propagation", "sequential", "simultaneous"])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.5, 0.8, 0.95])
def test_bounces_accumulate_where_the_series_says(e, law):
    """t∞ = √(2h/g) (1 + e) / (1 - e), whatever the number of bounces; afterwards the ball lies still."""
    world = begin(Scene((FLOOR, ball(0.5)), (Gravity(), Restitution(e), Resting())), Settings(impact_law=law))
    end = math.sqrt(1.0 / 9.81) * (1.0 + e) / (1.0 - e)
    advance(world, 1.001 * end)
    if e > 0.0:
        assert world.audit.last_bounce == pytest.approx(end, rel=1e-12 / (1.0 - e))
    assert world.mode[1] == STILL
    assert world.state().x[1, 2] == pytest.approx(0.1, abs=1e-14)


@pytest.mark.parametrize(
    ("height", "velocity"),
    [(1.5e3, (0.0, 0.0, 0.0)), (-1.38, (0.7, -0.3, 2.4)), (2.0, (20.0, 0.0, 0.0)), (0.0, (0.0, 0.0, -1e-6))],
    ids=["far up", "below the origin", "fast sideways", "slow"],
)
def test_bounces_end_where_rounding_alone_would_keep_them_up(height, velocity):
    """Positions are rounded: far from the origin, or beside a fast motion, the last bounces are noise."""
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, height))
    body = Body("ball", Sphere(0.11853493896012271), 2.0, (0.0, 0.0, height + 0.3), velocity=velocity)
    world = begin(Scene((floor, body), (Gravity(), Restitution(0.3), Resting())))
    advance(world, 2.0)
    fall = body.position[2] - height - body.shape.radius
    up, g = velocity[2], 9.81
    speed = math.sqrt(up * up + 2.0 * g * fall)
    end = (up + speed) / g + 2.0 * 0.3 * speed / (g * 0.7)
    # the time of the last bounce is known to what a rounding of the height makes of it
    grain = np.spacing(abs(height) + 0.3)
    assert world.audit.last_bounce == pytest.approx(end, abs=1e-14 + 20.0 * math.sqrt(grain / g))
    assert len(world.events) < 60
    assert abs(world.state().v[1, 2]) <= 1e-15
    assert world.state().x[1, 2] == pytest.approx(height + body.shape.radius, abs=4.0 * grain + 1e-14)


def test_bounces_end_on_a_floor_that_moves():
    slab = Body("floor", Box((80.0, 80.0, 1.0)), position=(0.0, 0.0, -0.5), velocity=(5.0, 0.0, 2.0))
    world = begin(Scene((slab, ball(0.4)), (Gravity(), Restitution(0.5), Resting())))
    advance(world, 2.0)
    assert len(world.events) < 60
    # lasting contact with a floor that moves is integrated, to 1e-12
    assert world.state().v[1] == pytest.approx((0.0, 0.0, 2.0), abs=1e-12)
    assert world.state().x[1, 2] == pytest.approx(0.1 + 4.0, abs=1e-12)


def test_bounces_in_the_air_end_too():
    world = begin(Scene((FLOOR, ball(0.5)), (Gravity(), Restitution(0.5), Resting(), Drag(0.2))))
    advance(world, 4.0)
    assert world.mode[1] == STILL


def test_an_edge_that_hangs_over_slides_off_and_turns():
    """A plate falls with its edge on a smaller box: two axes separate them equally well, and only one does so for long.

    Energy and momentum across the floor are kept.
    """
    lower = Body("lower", Box((0.5, 0.4, 0.5)), 0.5, (0.5, -0.5, 0.25), velocity=(1.0, -1.0, 0.0),
                 angular_velocity=(0.0, -3.0, 0.0))  # fmt: skip
    upper = Body("upper", Box((0.25, 0.5, 0.5)), 0.08, (0.5, -0.5, 1.45), velocity=(0.0, 0.0, 1.0),
                 angular_velocity=(0.0, 1.0, 2.0))  # fmt: skip
    scene = Scene((FLOOR, lower, upper), (Gravity(), Rotation(), Restitution(1.0), Resting()))
    world = begin(scene)
    advance(world, 1.0)
    end = world.state()
    assert 0.5 * end.v[1, :2] + 0.08 * end.v[2, :2] == pytest.approx((0.5, -0.5), abs=1e-12)
    assert len(world.events) < 1000


@pytest.mark.parametrize("law", ["propagation", "simultaneous"])
@pytest.mark.parametrize("seed", range(12))
def test_a_fast_room_does_not_keep_a_low_bounce_alive(seed, law):
    """Where the time scale is short bounces of a rounding's height come before those that are brief.

    Found a rounding of its place too late, a ball would arrive for ever as fast as it left.
    """
    rng = np.random.default_rng(seed)
    e, depth = float(rng.uniform(0.1, 0.9)), float(rng.uniform(0.5, 30.0))
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, -depth))
    ball = Body("ball", Sphere(0.1), 2.0, (0.3, 0.2, 0.2 - depth), velocity=(2.0, 0.0, -0.5))
    fast = Body("fast", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 50.0, 1.0), velocity=(200.0, 0.0, 0.0))
    world = begin(Scene((floor, ball, fast), (Gravity(), Restitution(e), Resting())), Settings(impact_law=law))
    struck = math.sqrt(0.25 + 2.0 * 9.81 * 0.1)
    end = (struck - 0.5) / 9.81 + 2.0 * struck * e / (9.81 * (1.0 - e))
    advance(world, 1.1 * end)
    # from the first speed down to that of a bounce as high as a rounding
    least = math.sqrt(2.0 * 9.81 * 2.0**-52 * depth)
    assert len(world.events) <= math.log(struck / least) / -math.log(e) + 5
    grain = np.spacing(depth)
    assert world.audit.last_bounce == pytest.approx(end, abs=1e-14 + 20.0 * math.sqrt(grain / 9.81))


def test_forces_that_cease_to_exist_where_a_contact_ceases_to_slide_are_replaced_by_one_impulse():
    """A ball rolls on the floor, a plate slides on it and carries a heavy ball that slides on the plate.

    A moment before the plate would slide the other way no contact forces exist any more (every set of contacts that
    push and hold was tried): an impulse stops both slips, leaves no trace of motion, and the three go on together.
    """
    low = Body("low", Sphere(0.1), 0.5, (0.10293878000442405, -0.08055974013472177, 0.1),
               (0.7184749988707327, 0.4725353741675695, 0.38678044716925675, 0.3330238457611791),
               (0.38408783946384684, -0.5449571685452217, 0.0),
               (5.449571685452216, 3.840878394638468, 2.549407776175608))  # fmt: skip
    plate = Body("plate", Box((0.25, 0.2, 0.25)), 0.5,
                 (0.05568032903015477, -0.15158667869424938, 0.35412705138208467),
                 (0.4913131856017869, 0.07191370373269065, -0.20805564127992937, -0.8427055375401709),
                 (0.017979299862953595, -0.650465621771587, 0.5040128730997399),
                 (-2.5585128571393443, -1.838114079609285, -3.438190812952623))  # fmt: skip
    high = Body("high", Sphere(0.25), 35.82593378012382,
                (-0.05683604176555952, 0.06022827747726969, 0.6631270124788572),
                (0.8889953411136383, -0.3495820713246793, -0.29576043062009066, -0.0023294990902130454),
                (-0.29589623968069845, 0.3028201678913363, -0.34621909223808717),
                (-2.821886211437932, -2.858205508122832, 0.04547031982234814))  # fmt: skip
    effects = (Gravity(), Rotation(), Friction(0.5), Restitution(0.5), Resting())
    world = begin(Scene((FLOOR, low, plate, high), effects))
    advance(world, 0.01)
    assert [(i.what, i.time) for i in world.incidents] == [("painleve", pytest.approx(7.29e-5, abs=1e-6))]
    assert world.audit.residual <= 1e-12
    assert world.audit.step_rise <= 1e-10


def beads(masses, e, gap=0.0):
    """Balls in a row along x, of which the first comes at 1 m/s."""
    balls = [
        Body(f"b{k}", Sphere(0.05), float(m), ((0.1 + gap) * k, 0.0, 0.0), velocity=(float(k == 0), 0.0, 0.0))
        for k, m in enumerate(masses)
    ]
    return begin(Scene(tuple(balls), (Restitution(e),)))


def test_a_blow_runs_through_two_hundred_beads_that_touch():
    """Equal masses, e = 1: the last bead leaves with the whole velocity, and not one other moves."""
    world = beads([1.0] * 200, 1.0)
    advance(world, 1e-3)
    assert world.state().v[:, 0].tolist() == pytest.approx([0.0] * 199 + [1.0], abs=1e-13)
    assert np.abs(world.state().v[:199, 0]).max() <= 1e-15
    assert world.audit.passes == 199
    assert world.audit.stopped == 0


@pytest.mark.parametrize(("e", "gap"), [(1.0, 0.0), (1.0, 1e-6), (0.9, 1e-3)])
def test_a_row_of_unequal_beads_keeps_momentum_and_makes_no_energy(e, gap):
    """Sixty masses between 1 and 100: what comes back and forth is not cut off while nothing is lost."""
    masses = 10.0 ** np.random.default_rng(5).uniform(0.0, 2.0, 60)
    world = beads(masses, e, gap)
    advance(world, 1e-3)
    v = world.state().v[:, 0]
    assert masses @ v == pytest.approx(masses[0], rel=1e-13)
    if e == 1.0:
        assert masses @ v**2 == pytest.approx(masses[0], rel=1e-12)
        assert world.audit.stopped == 0
    assert masses @ v**2 <= masses[0] * (1.0 + 1e-13)


def test_an_impact_that_would_go_on_for_ever_is_stopped_and_told():
    """Five balls close up in infinitely many, ever weaker passes: in the end they move together, on record."""
    world = beads([1.0] * 5, 0.1)
    advance(world, 1e-3)
    assert world.audit.stopped == 1
    assert [i.what for i in world.incidents] == ["stopped impact"]
    assert world.state().v[:, 0] == pytest.approx([0.2] * 5, abs=1e-9)
    assert np.diff(world.state().v[:, 0]).min() >= -1e-12
