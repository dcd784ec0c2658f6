"""Solvers of the contact problem: they agree with each other, each has its limits, and none is believed unseen."""

from functools import cache
from itertools import combinations

import numpy as np
import pytest

from reference_impl import contact_problem, contact_solvers
from reference_impl.contact_problem import GOOD, NoSolution, residual, solve
from reference_impl.contact_solvers import SOLVERS

EXACT = ("auto", "nnls", "dantzig", "lemke")  # finite: they end at rounding
FIRST_ORDER = ("osqp", "osqp_dual")  # end at their tolerance of 1e-9 where polishing does not help
GRAVITY = 9.81


def random_problem(seed, wide, moving):
    """Up to 30 contacts of up to 8 bodies, a fifth of them duplicates; masses equal, or spread over 1 to 1e6."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 9)), int(rng.integers(1, 31))
    mass = 10.0 ** rng.uniform(0.0, 6.0, n) if wide else np.ones(n)
    g = np.zeros((m, 6 * n))
    for k in range(m):
        if k and rng.random() < 0.2:
            g[k] = g[rng.integers(k)]
            continue
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        a, b = int(rng.integers(n)), int(rng.integers(-1, n))
        for i, sign in ((a, 1.0), (b, -1.0)):
            if i >= 0 and not (i == a and sign < 0.0):
                g[k, 6 * i : 6 * i + 3] = sign * normal / np.sqrt(mass[i])
                lever = np.cross(rng.normal(size=3), normal)
                g[k, 6 * i + 3 : 6 * i + 6] = sign * lever / np.sqrt(0.4 * mass[i])
    g /= np.linalg.norm(g, axis=1)[:, None]
    c, reachable = ((rng.normal(size=(n, 6)) * np.sqrt(mass)[:, None]).ravel() for _ in range(2))
    return g, c, g @ reachable if moving else np.zeros(m)


def stack_problem(masses):
    """Unit cubes on four corners each: unit rows, scaled gravity, row lengths, load of every layer [N]."""
    n = len(masses)
    g, c = np.zeros((4 * n, 6 * n)), np.zeros(6 * n)
    corners = [(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    up = np.array([0.0, 0.0, 1.0])
    for i, mass in enumerate(masses):
        c[6 * i + 2] = -GRAVITY * np.sqrt(mass)
        for k, (x, y) in enumerate(corners):
            for body, sign, z in ((i, 1.0, -0.5), (i - 1, -1.0, 0.5)):
                if body >= 0:
                    g[4 * i + k, 6 * body : 6 * body + 3] = sign * up / np.sqrt(masses[body])
                    lever = np.cross([x, y, z], up)
                    g[4 * i + k, 6 * body + 3 : 6 * body + 6] = sign * lever / np.sqrt(masses[body] / 6.0)
    length = np.linalg.norm(g, axis=1)
    return g / length[:, None], c, length, GRAVITY * np.cumsum(masses[::-1])[::-1]


STACKS = {
    "equal": lambda n: [1.0] * n,
    "lid 1e3": lambda n: [1.0] * (n - 1) + [1e3],
    "lid 1e6": lambda n: [1.0] * (n - 1) + [1e6],
    "alternating 1e3": lambda n: [1e3 if i % 2 else 1.0 for i in range(n)],
    "alternating 1e6": lambda n: [1e6 if i % 2 else 1.0 for i in range(n)],
}


@cache
def load_error(solver, stack, n):
    """Greatest relative error of the load a layer carries, as the solver itself returns it; inf where it gives up."""
    g, c, length, loads = stack_problem(STACKS[stack](n))
    f = SOLVERS[solver](g, c, np.zeros(len(g)), None)
    carried = (f / length).reshape(-1, 4).sum(axis=1)
    return float(np.nan_to_num(np.abs(carried / loads - 1.0).max(), nan=np.inf))


def worst(solver, stack):
    return max(load_error(solver, stack, n) for n in (2, 5, 10))


@pytest.fixture(scope="module")
def answers():
    """What every solver says to 300 random problems: solver -> residuals, motions."""
    said = {name: ([], []) for name in SOLVERS}
    for seed in range(75):
        for wide in (False, True):
            for moving in (False, True):
                g, c, d = random_problem(seed, wide, moving)
                scale = max(np.linalg.norm(c), np.abs(d).max())
                for name, (residuals, motions) in said.items():
                    f = SOLVERS[name](g, c, d, None)
                    residuals.append(residual(g, c, d, f))
                    motions.append((c + g.T @ f) / scale)
    return said


@pytest.mark.parametrize("solver", EXACT)
def test_finite_methods_solve_every_random_problem_to_rounding(answers, solver):
    assert max(answers[solver][0]) <= 1e-12


@pytest.mark.parametrize("solver", FIRST_ORDER)
def test_osqp_ends_at_its_tolerance(answers, solver):
    residuals = np.array(answers[solver][0])
    assert residuals.max() <= 1e-8
    assert np.mean(residuals <= 1e-10) >= 0.95


def test_gauss_seidel_solves_most_and_not_all(answers):
    residuals = np.array(answers["pgs"][0])
    assert np.mean(residuals <= 1e-6) >= 0.95
    assert residuals.max() > 1e-6


@pytest.mark.parametrize(("one", "other"), list(combinations((*EXACT, *FIRST_ORDER), 2)))
def test_every_pair_of_solvers_finds_the_same_motion(answers, one, other):
    # forces of redundant contacts are not unique, the motion is; it errs by about the residual times the pivots'
    # condition, and a first-order method by more than its residual
    allowed = 1e-11 if {one, other} <= set(EXACT) else 1e-6
    for x, y in zip(answers[one][1], answers[other][1], strict=True):
        assert np.abs(x - y).max() <= allowed


@pytest.mark.parametrize("stack", STACKS)
@pytest.mark.parametrize("solver", ["auto", "nnls"])
def test_non_negative_least_squares_carries_every_stack(solver, stack):
    assert worst(solver, stack) <= 1e-12


@pytest.mark.parametrize("stack", STACKS)
@pytest.mark.parametrize("solver", ["osqp", "dantzig"])
def test_the_factor_form_carries_every_stack(solver, stack):
    # the certificate is 1e-12 of the heaviest weight; the lightest load is a millionth of that
    assert worst(solver, stack) <= (1e-7 if "1e6" in stack else 1e-9)


def test_the_square_form_carries_equal_boxes():
    assert worst("osqp_dual", "equal") <= 1e-8
    assert worst("lemke", "equal") <= 1e-11


@pytest.mark.parametrize("stack", ["lid 1e6", "alternating 1e6"])
def test_the_square_form_is_lost_at_a_mass_ratio_of_a_million(stack):
    assert worst("osqp_dual", stack) > 1.0
    assert worst("lemke", stack) > 0.1


@pytest.mark.parametrize("stack", [name for name in STACKS if name != "equal"])
def test_gauss_seidel_does_not_carry_unequal_masses(stack):
    assert worst("pgs", stack) > 0.1


def test_gauss_seidel_misses_the_certificate_under_a_heavy_lid():
    g, c, _, _ = stack_problem(STACKS["lid 1e6"](10))
    assert residual(g, c, np.zeros(len(g)), SOLVERS["pgs"](g, c, np.zeros(len(g)), None)) > 1e-6


@pytest.mark.parametrize("asked", SOLVERS)
def test_whoever_is_asked_the_answer_is_certified(asked):
    for stack, masses in STACKS.items():
        g, c, length, loads = stack_problem(masses(5))
        answer = solve(g * length[:, None], c, np.zeros(len(g)), asked)
        assert answer.residual <= GOOD
        # refined on the active set, which gives the loads to rounding whoever found it
        assert answer.f.reshape(-1, 4).sum(axis=1) == pytest.approx(loads, rel=1e-9), stack


def wrong(g, c, d, start):
    return np.full(len(d), 3.0)


def not_a_number(g, c, d, start):
    return np.full(len(d), np.nan)


def false_alarm(g, c, d, start):
    raise RuntimeError("problem infeasible")


def late(g, c, d, start):
    raise TimeoutError("no answer in time")


def misshapen(g, c, d, start):
    return np.zeros(len(d) + 1)


def nothing(g, c, d, start):
    return np.zeros(len(d))


@pytest.mark.parametrize("liar", [wrong, not_a_number, false_alarm, late, misshapen, nothing])
def test_a_solver_that_lies_is_not_believed(monkeypatch, liar):
    monkeypatch.setitem(SOLVERS, "nnls", liar)
    for seed in range(10):
        g, c, d = random_problem(seed, True, False)
        if len(d) == 1 or (g @ c >= d).all():
            continue
        answer = solve(g, c, d, "nnls")
        assert residual(g, c, d, answer.f) <= GOOD
        # the set of loaded contacts of a liar may happen to be right; then the forces are the house's
        assert answer.solver == "dantzig" or liar is wrong


@pytest.mark.parametrize("stack", STACKS)
def test_what_is_kept_serves_the_same_contacts_a_moment_later(stack):
    g, c, _, _ = stack_problem(STACKS[stack](10))
    first = solve(g, c, np.zeros(len(g)), guess=np.ones(len(g), dtype=bool))
    rng = np.random.default_rng(0)
    moved = g + 1e-3 * rng.uniform(size=6 * 10) * g  # the motion of every body measured by another scale
    later = solve(moved, 1.1 * c, np.zeros(len(g)), kept=first.kept)
    afresh = solve(moved, 1.1 * c, np.zeros(len(g)))
    # under the lid a thousandth of change is too much for the old factor, which is noticed, and others are asked
    assert later.solver == "guess" or stack == "lid 1e6"
    assert later.residual <= 1e-12
    # the motion is unique; the forces of four corners each are not
    assert np.abs(later.x - afresh.x).max() <= 1e-11 * np.abs(c).max()


def test_what_is_kept_is_dropped_where_other_contacts_push():
    g, c, _, _ = stack_problem([1.0] * 3)
    first = solve(g, c, np.zeros(len(g)), guess=np.ones(len(g), dtype=bool))
    lifted = c.copy()
    lifted[14] = 5.0  # the top box is pulled off
    answer = solve(g, lifted, np.zeros(len(g)), kept=first.kept)
    assert answer.residual <= GOOD
    assert np.abs(answer.f[8:]).max() == 0.0
    assert np.abs(answer.x[[2, 8]]).max() <= 1e-14


def test_without_an_honest_solver_there_is_no_answer(monkeypatch):
    for name in SOLVERS:
        monkeypatch.setitem(SOLVERS, name, nothing)
    g, c, _, _ = stack_problem([1.0, 1.0])
    with pytest.raises(NoSolution, match="best certificate"):
        solve(g, c, np.zeros(len(g)))


def test_a_body_squeezed_by_two_moving_walls_has_no_solution():
    g = np.array([[1.0, 0, 0, 0, 0, 0], [-1.0, 0, 0, 0, 0, 0]])
    with pytest.raises(NoSolution):
        solve(g, np.zeros(6), np.array([1.0, 1.0]))


@pytest.mark.parametrize("solver", ["dantzig", "lemke"])
def test_a_pivoting_method_out_of_time_gives_up(monkeypatch, solver):
    monkeypatch.setattr(contact_solvers, "SECONDS", 0.0)
    g, c, _, _ = stack_problem([1.0] * 5)
    assert np.isnan(SOLVERS[solver](g, c, np.zeros(len(g)), None)).all()


def test_auto_changes_its_method_with_the_size(monkeypatch):
    asked = []
    for name in ("nnls", "osqp"):
        monkeypatch.setattr(contact_solvers, name, lambda g, c, d, start, name=name: asked.append(name))
    for n in (5, 25):
        g, c, _, _ = stack_problem([1.0] * n)
        contact_solvers.auto(g, c, np.zeros(len(g)))
    assert asked == ["nnls", "osqp"]


@pytest.mark.parametrize("solver", ["osqp", "osqp_dual", "pgs"])
def test_a_start_at_the_answer_is_kept(solver):
    g, c, length, loads = stack_problem([1.0] * 4)
    truth = np.repeat(loads / 4.0, 4) * length
    f = SOLVERS[solver](g, c, np.zeros(len(g)), truth)
    assert (f / length).reshape(-1, 4).sum(axis=1) == pytest.approx(loads, rel=1e-9)


@pytest.mark.parametrize("solver", SOLVERS)
def test_solvers_say_nothing(capfd, solver):
    for seed in range(20):
        SOLVERS[solver](*random_problem(seed, False, True), None)
    g, c, _, _ = stack_problem([1.0, 1.0])
    SOLVERS[solver](g, c, np.zeros(len(g)), None)
    assert capfd.readouterr() == ("", "")


def test_every_name_is_a_solver_with_its_limits():
    assert set(contact_problem.RESCUERS) < set(SOLVERS)
    assert all(solver.__doc__ for solver in SOLVERS.values())


def hard_problem(seed):
    """Up to 40 contacts with every difficulty at once: copies, unit and mass scales from 1e-6 to 1e6, speeds of 1e-17.

    Rank is deficient (few bodies, many contacts), each contact asks for a rate of its own (its own e u⁻), and the whole
    is measured in units of any size.
    """
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 5)), int(rng.integers(1, 21))
    width = 6 * n
    g = rng.normal(size=(m, width)) * (rng.uniform(size=(m, width)) < 0.6) * 10.0 ** rng.uniform(-1.5, 1.5, width)
    g[:, 0] += 1e-3 * rng.normal(size=m)
    kind = rng.integers(4)
    if kind == 1:  # the same contact up to a hundred times
        g = np.repeat(g[:3], rng.integers(1, 34, len(g[:3])), axis=0)[:100]
    if kind == 2:  # of low rank: all rows from three directions
        g = np.abs(rng.normal(size=(m, 3))) @ rng.normal(size=(3, width))
    g *= 10.0 ** rng.uniform(-6.0, 6.0)
    c = rng.normal(size=width) * 10.0 ** rng.uniform(-6.0, 6.0)
    d = g @ c + np.abs(g @ rng.normal(size=width) * np.abs(c).max()) * rng.uniform(-1.0, 0.0)
    if kind == 3:  # nothing approaches, or hardly anything
        d = g @ c + np.linalg.norm(g, axis=1) * np.abs(c).max() * rng.choice([1e-17, -1e-17, 0.0], m)
    return g, c, d


@pytest.mark.parametrize("asked", SOLVERS)
def test_hard_problems_are_solved_whoever_is_asked_or_refused(asked):
    """The same 150 for every solver that is asked first: 0 <= f, G x >= d, f·(G x - d) = 0 at any scale."""
    answered = 0
    for seed in range(150):
        g, c, d = hard_problem(seed)
        try:
            answer = solve(g, c, d, asked)
        except NoSolution:
            continue
        answered += 1
        length = np.linalg.norm(g, axis=1)
        scale = max(np.linalg.norm(c), np.abs(d / length).max())
        assert answer.residual <= GOOD
        f, a = answer.f * length, answer.a / length
        assert f.min() >= -GOOD * scale
        assert np.abs(np.minimum(f, (g @ answer.x - d) / length)).max() <= 1e-9 * scale
        assert a == pytest.approx((g @ answer.x - d) / length, abs=1e-9 * scale)
        # the motion is what the forces make of c
        assert np.abs(answer.x - c - g.T @ answer.f).max() <= 1e-6 * scale
    assert answered >= 145


def test_contacts_between_bodies_that_nothing_moves_have_no_say():
    """A contact row of bodies that both have infinite mass is zero; it is refused, not divided by."""
    g = np.array([[1.0, 0.0], [0.0, 0.0]])
    with pytest.raises(ValueError, match="row 1 is zero"):
        solve(g, np.array([-1.0, 0.0]), np.zeros(2))


def test_more_contacts_than_fit_are_refused_at_once():
    """A hundred thousand contacts in one problem would need tables of 80 GB: it says so."""
    g = np.broadcast_to(np.array([1.0, 0.0, 0.0]), (100_000, 3))
    with pytest.raises(NoSolution, match="100000 contacts"):
        solve(g, np.array([-1.0, 0.0, 0.0]), np.zeros(100_000))
