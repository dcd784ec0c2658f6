"""Random scenes for tests of the reference engine, and what may be done to a scene without changing its physics."""

from dataclasses import replace

import numpy as np

from mechanics.effects import Drag, Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import normalised, product, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import State

FLOOR = Body("floor", HalfSpace())
MIRROR = np.array((1.0, -1.0, 1.0))  # y -> -y of a vector; of a spin and of a quaternion's vector part the negative


def triple(values):
    """A vector as a scene takes it."""
    return tuple(np.asarray(values, dtype=np.float64).tolist())


def attitude(rng):
    """A random unit quaternion."""
    return tuple(normalised(rng.normal(size=4)).tolist())


def body(rng, name, position, *, boxes=True, velocity=(0.0, 0.0, 0.0), spin=0.0):
    """A body of 0.2 to 0.5 m and 0.5 to 3 kg in a random attitude: a sphere, or as often a box."""
    if boxes and rng.random() < 0.5:
        shape = Box(triple(rng.uniform(0.2, 0.5, 3)))
    else:
        shape = Sphere(float(rng.uniform(0.1, 0.2)))
    mass, q = float(rng.uniform(0.5, 3.0)), attitude(rng)
    return Body(name, shape, mass, triple(position), q, triple(velocity), triple(spin * rng.normal(size=3)))


def cloud(seed, *, count=4, boxes=True, e=1.0, turning=True, effects=()):
    """Bodies in empty space that fly at each other from the corners of a cube of 1.6 m."""
    rng = np.random.default_rng(seed)
    corners = rng.permutation(np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]))[:count]
    bodies = [
        body(rng, f"b{i}", 0.8 * at, boxes=boxes, velocity=-1.5 * at + 0.3 * rng.normal(size=3), spin=3.0 * turning)
        for i, at in enumerate(corners)
    ]
    return Scene(tuple(bodies), (Restitution(e), *((Rotation(),) if turning else ()), *effects))


def pile(seed, *, count=2, boxes=True, e=0.3, mu=0.0, effects=()):
    """Bodies thrown one above the other on a floor."""
    rng = np.random.default_rng(seed)
    bodies = []
    for i in range(count):
        at = (*rng.uniform(-0.1, 0.1, 2), 0.5 + 0.8 * i)
        bodies.append(body(rng, f"b{i}", at, boxes=boxes, velocity=0.5 * rng.normal(size=3), spin=2.0))
    rough = (Friction(mu),) if mu else ()
    return Scene((FLOOR, *bodies), (Gravity(), Rotation(), Restitution(e), Resting(), *rough, *effects))


def turned(scene, q=(1.0, 0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0), boost=(0.0, 0.0, 0.0)):
    """The scene turned by q about the origin, then moved by `shift` [m] and set in motion with `boost` [m/s]."""
    q = np.array(q)

    def world(value):
        return triple(rotate(q, np.array(value)))

    bodies = tuple(
        replace(
            b,
            position=triple(rotate(q, np.array(b.position)) + shift),
            orientation=triple(product(q, np.array(b.orientation))),
            velocity=triple(rotate(q, np.array(b.velocity)) + boost),
            angular_velocity=world(b.angular_velocity),
            acceleration=world(b.acceleration),
        )
        for b in scene.bodies
    )
    return Scene(bodies, tuple(_effect(e, world, world, lambda p: p) for e in scene.effects))


def mirrored(scene):
    """The scene seen in the plane y = 0."""

    def vector(value):
        return triple(MIRROR * value)

    def spin(value):
        return triple(-MIRROR * value)

    bodies = tuple(
        replace(
            b,
            shape=HalfSpace(vector(b.shape.normal)) if isinstance(b.shape, HalfSpace) else b.shape,
            position=vector(b.position),
            orientation=(b.orientation[0], *spin(b.orientation[1:])),
            velocity=vector(b.velocity),
            angular_velocity=spin(b.angular_velocity),
            acceleration=vector(b.acceleration),
        )
        for b in scene.bodies
    )
    return Scene(bodies, tuple(_effect(e, vector, spin, vector) for e in scene.effects))


def scaled(scene, length=1.0, time=1.0, mass=1.0):
    """The same scene told in units smaller by these factors: every number of metres is `length` times what it was."""
    speed, force = length / time, mass * length / time**2

    def times(value, factor):
        return triple(np.array(value) * factor)

    def shape(s):
        if isinstance(s, Box):
            return Box(times(s.size, length))
        return Sphere(s.radius * length) if isinstance(s, Sphere) else s

    bodies = tuple(
        replace(
            b,
            shape=shape(b.shape),
            mass=None if b.mass is None else b.mass * mass,
            position=times(b.position, length),
            velocity=times(b.velocity, speed),
            angular_velocity=times(b.angular_velocity, 1.0 / time),
            acceleration=times(b.acceleration, speed / time),
        )
        for b in scene.bodies
    )

    def effect(e):
        match e:
            case Gravity(g):
                return Gravity(times(g, speed / time))
            case Drag(linear, angular, names):
                return Drag(linear * mass / time, angular * mass * length**2 / time, names)
            case Force():
                return Force(e.body, times(e.force, force), times(e.torque, force * length), times(e.point, length),
                             e.start * time, e.end * time)  # fmt: skip
        return e

    return Scene(bodies, tuple(effect(e) for e in scene.effects))


def permuted(scene, order):
    """The scene with its bodies listed in another order."""
    return Scene(tuple(scene.bodies[i] for i in order), scene.effects)


def continued(scene, state: State, sign=1.0):
    """The scene whose bodies start from `state`, their velocities times `sign`."""
    bodies = tuple(
        replace(b, position=triple(state.x[i]), orientation=triple(state.q[i]), velocity=triple(sign * state.v[i]),
                angular_velocity=triple(sign * state.w[i]))
        for i, b in enumerate(scene.bodies)
    )  # fmt: skip
    return Scene(bodies, scene.effects)


def inertia(scene, i, q):
    """Inertia tensor of body i in the attitude q, world frame [kg m2]."""
    axes = np.array([rotate(q, e) for e in np.eye(3)]).T
    return axes @ scene.bodies[i].inertia_tensor @ axes.T


def momentum(scene, state: State):
    """Momentum [kg m/s] and angular momentum about the origin [kg m2/s] of the moving bodies, (3,) each."""
    p, angular = np.zeros(3), np.zeros(3)
    for i in scene.moving:
        push = scene.bodies[i].mass * state.v[i]
        p += push
        angular += np.cross(state.x[i], push) + inertia(scene, i, state.q[i]) @ state.w[i]
    return p, angular


def energy(scene, state: State):
    """Kinetic and potential energy of the moving bodies under gravity [J]."""
    gravity = scene.effect(Gravity)
    g = np.array(gravity.acceleration) if gravity else np.zeros(3)
    return sum(
        scene.bodies[i].mass * (0.5 * state.v[i] @ state.v[i] - g @ state.x[i])
        + 0.5 * state.w[i] @ inertia(scene, i, state.q[i]) @ state.w[i]
        for i in scene.moving
    )


def _effect(effect, vector, spin, point):
    match effect:
        case Gravity(g):
            return Gravity(vector(g))
        case Force():
            return replace(effect, force=vector(effect.force), torque=spin(effect.torque), point=point(effect.point))
    return effect
