"""The rows of joints, and the motions that they leave free."""

import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from pendulums import PIVOT, bob

from mechanics.effects import Hinge, Rod, Rotation
from mechanics.rotation import exponential, matrix, normalised, product
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from reference_impl.collide.detect import Contacts
from reference_impl.effects.free_motions import Spanned, Turned, space
from reference_impl.effects.joint import AXIS, all_of, hinge, rod
from reference_impl.effects.resting import Island, Pose
from reference_impl.errors import Unsupported
from reference_impl.links import Links
from reference_impl.parts import Parts
from reference_impl.reactions import joint_forces
from reference_impl.simulate import begin
from reference_impl.state import bodies_of

NOTHING = Contacts(np.zeros((0, 5), dtype=np.int64), np.zeros((0, 14)), np.zeros(0, dtype=np.int64))


@pytest.mark.parametrize(("effects", "match"), [
    ((Rod("a", "b"),), r"Rod between 'a' and 'b': its ends part at 1 m/s"),
    ((Rotation(), Hinge("a", "b")), r"Hinge between 'a' and 'b': its ends part at 1 m/s"),
    ((Rod("f", "g"),), r"Rod between 'f' and 'g': its ends part at 2 m/s"),
    ((Hinge("f", "h"),), r"Hinge between 'f' and 'h': both are fixed and move against each other"),
])  # fmt: skip
def test_joints_that_cannot_hold_are_refused(effects, match):
    bodies = (
        bob("a", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), bob("b", (2.0, 0.0, 0.0)), Body("f", Sphere(0.1)),
        Body("g", Sphere(0.1), position=(1.0, 0.0, 0.0), velocity=(2.0, 0.0, 0.0)),
        Body("h", Sphere(0.1), position=(0.0, 3.0, 0.0), acceleration=(0.0, 1.0, 0.0)),
    )  # fmt: skip
    with pytest.raises(Unsupported, match=match):
        begin(Scene(bodies, effects))


def test_a_joint_between_fixed_bodies_holds_nothing():
    world = begin(Scene((PIVOT, Body("f", Sphere(0.1), position=(1.0, 0.0, 0.0))), (Rod("pivot", "f"),)))
    assert world.links is None
    assert not joint_forces(world)


def test_rows_are_the_derivatives_of_their_gaps():
    """Along random motions gap' is the slope of the gap and gap'' = J·accelerations + bias that of gap'."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        bodies = tuple(
            Body(f"b{i}", Box(tuple(rng.uniform(0.2, 1.0, 3))), float(rng.uniform(0.5, 2.0)),
                 tuple(rng.normal(size=3)), tuple(normalised(rng.normal(size=4))))
            for i in range(2)
        )  # fmt: skip
        effects = (Rod("b0", "b1", tuple(rng.normal(size=3)), tuple(rng.normal(size=3))),
                   Hinge("b1", "b0", tuple(rng.normal(size=3)), tuple(rng.normal(size=3))))  # fmt: skip
        scene = Scene(bodies, (Rotation(), *effects))
        b = bodies_of(scene)
        joints = all_of(rod(scene, effects[0]).joints + hinge(scene, effects[1]).joints)
        island = Island(np.array((0, 1)), NOTHING, np.array((0, 1)),
                        Links.of(Parts(joints=(joints,)), np.ones(2, dtype=bool)))  # fmt: skip
        x, v, a, w, alpha = rng.normal(size=(5, 2, 3))
        q0 = normalised(rng.normal(size=(2, 4)))

        def at(t, x=x, v=v, a=a, w=w, alpha=alpha, q0=q0, b=b):
            # turns w t + ½ alpha t² about the world's axes, to second order in t
            q = product(exponential(w * t + 0.5 * alpha * t * t), q0)
            spin = w + alpha * t
            rotation = np.array([matrix(one) for one in q])
            momentum = np.array([r @ i @ r.T @ s for r, i, s in zip(rotation, b.inertia, spin, strict=True)])
            return Pose(x + v * t + 0.5 * a * t * t, rotation, v + a * t, spin, momentum)

        h = 1e-5
        low, middle, high = (island.rows(at(t), b) for t in (-h, 0.0, h))
        assert (high.gap - low.gap) / (2.0 * h) == pytest.approx(middle.rate, abs=1e-8)
        y = np.concatenate([np.concatenate([a[i] / math.sqrt(b.inverse_mass[i]),
                                            np.linalg.solve(b.root[i], at(0.0).rotation[i].T @ alpha[i])])
                            for i in (0, 1)])  # fmt: skip
        second = middle.j @ y - middle.target
        assert (high.rate - low.rate) / (2.0 * h) == pytest.approx(second, abs=1e-7)
        assert (joints.kinds[:, 0] == AXIS).sum() == 2


def chain_rows(rng, links, masses, loop=False):
    """Scaled rows of links that are hinged to each other in space; of a loop those that closed it, too."""
    bodies = tuple(
        Body(f"b{i}", Box(tuple(rng.uniform(0.2, 1.0, 3))), mass, tuple(rng.normal(size=3)))
        for i, mass in zip(range(links), masses, strict=True)
    )
    hinges = [Hinge(a.name, b.name, tuple(rng.normal(size=3)), tuple(rng.normal(size=3))) for a, b in pairwise(bodies)]
    hinges += [hinges[0]] if loop else []
    scene = Scene(bodies, (Rotation(), *hinges))
    b, every = bodies_of(scene), np.arange(links)
    joints = all_of(tuple(part for effect in hinges for part in hinge(scene, effect).joints))
    links = Links.of(Parts(joints=(joints,)), np.ones(links, dtype=bool))
    motion = begin(scene).motion
    return Island(every, NOTHING, every, links).rows(Pose.now(motion, b), b).j


@pytest.mark.parametrize("heavy", [1.0, 1e4])
def test_free_motions_are_the_projection_of_gauss(heavy):
    """Against the normal equations in 60 digits: Jᵀ (J Jᵀ)⁻¹ of what the joints take and of what they demand."""
    rng = np.random.default_rng(5)
    j = chain_rows(rng, 5, (1.0, heavy, 1.0, 1.0, heavy))
    target, motion = rng.normal(size=len(j)), rng.normal(size=j.shape[1])
    with mpmath.workdps(60):
        exact = mpmath.matrix(j.tolist())
        square = exact * exact.T
        pull = mpmath.lu_solve(square, exact * mpmath.matrix(motion.tolist()))
        given = exact.T * mpmath.lu_solve(square, mpmath.matrix(target.tolist()))
        taken = np.array([float(c) for c in exact.T * pull])
        pull, given = (np.array([float(c) for c in vector]) for vector in (pull, given))
    s = space(j, target)
    assert isinstance(s, Turned)
    # rounding of rows of unit length, grown by how little the least of their combinations leaves of them
    unit = j / np.linalg.norm(j, axis=1)[:, None]
    grown = 1e-15 * np.linalg.cond(unit)
    assert np.abs(s.given - given).max() <= grown * np.abs(given).max()
    assert np.abs(s.within(motion) - (motion - taken)).max() <= grown
    assert np.abs(s.forces(motion) - pull).max() <= grown * np.linalg.cond(unit) * np.abs(pull).max()
    several = rng.normal(size=(3, j.shape[1]))
    assert (s.within(several)[1] == s.within(several[1])).all()


@pytest.mark.parametrize("links", [2, 3, 7])
def test_rows_that_repeat_each_other_leave_the_same_motions_free(links):
    """A hinge that is there twice takes no more than once, and each of the two carries half."""
    rows = [chain_rows(np.random.default_rng(8), links, (1.0,) * links, loop) for loop in (False, True)]
    motion = np.random.default_rng(9).normal(size=rows[0].shape[1])
    once, twice = (space(j, j @ motion) for j in rows)
    assert isinstance(once, Turned)
    assert isinstance(twice, Spanned)
    assert twice.given == pytest.approx(once.given, abs=1e-13)
    assert twice.within(motion) == pytest.approx(once.within(motion), abs=1e-13)
    f, shared = once.forces(motion), twice.forces(motion)
    assert shared[:5] == pytest.approx(0.5 * f[:5], abs=1e-12)
    assert shared[-5:] == pytest.approx(0.5 * f[:5], abs=1e-12)


def test_rows_in_any_order_leave_the_same_motions_free():
    rng = np.random.default_rng(11)
    j = chain_rows(rng, 6, (1.0,) * 6)
    target, motion = rng.normal(size=len(j)), rng.normal(size=j.shape[1])
    order, bodies = rng.permutation(len(j)), rng.permutation(6)
    columns = (6 * bodies[:, None] + np.arange(6)).ravel()
    s, mixed = space(j, target), space(j[order][:, columns], target[order])
    assert mixed.given == pytest.approx(s.given[columns], abs=1e-13)
    assert mixed.within(motion[columns]) == pytest.approx(s.within(motion)[columns], abs=1e-13)
    assert mixed.forces(motion[columns]) == pytest.approx(s.forces(motion)[order], abs=1e-12)
