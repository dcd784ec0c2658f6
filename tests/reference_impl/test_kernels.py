"""Compiled code is kept exactly as long as nothing it depends on has changed."""

import math
import subprocess
import sys

import numpy as np
import pytest

from reference_impl import kernels
from reference_impl.kernels import kernel, matrix

compiled = pytest.mark.skipif(not isinstance(matrix, kernels.Kernel), reason="NUMBA_DISABLE_JIT")
ANGLE = math.pi / 3.0


@kernel
def inner(x):
    """Twice x."""
    return 2.0 * x


@kernel
def outer(x):
    """Four times x, turned."""
    return inner(inner(x)) * math.cos(ANGLE)


def scaled(factor):
    """Kernels that differ in a constant alone."""

    @kernel
    def times(x):
        return factor * x

    return times


def changed(function, **names):
    """The same function among other globals."""
    return kernels.Kernel(type(function.function)(function.function.__code__, {**globals(), **names}, "outer"))


def test_kernels_call_kernels():
    assert outer(1.0) == pytest.approx(2.0)
    assert scaled(3.0)(2.0) == 6.0
    assert scaled(4.0)(2.0) == 8.0


def test_a_kernel_keeps_its_name_and_words():
    assert matrix.__name__ == "matrix"
    assert "Rotation matrix" in matrix.__doc__


@compiled
def test_the_stamp_depends_on_everything_a_kernel_refers_to():
    same = outer.stamp()
    assert outer.stamp() == same
    assert changed(outer).stamp() == same
    assert changed(outer, inner=scaled(2.0)).stamp() != same
    assert changed(outer, ANGLE=0.0).stamp() != same
    assert changed(outer, ANGLE=np.zeros(3)).stamp() != changed(outer, ANGLE=np.ones(3)).stamp()
    assert scaled(2.0).stamp() != scaled(3.0).stamp()
    assert scaled(2.0).stamp() == scaled(2.0).stamp()


@compiled
def test_the_stamp_sees_through_modules():
    def far(x):
        return kernels.norm(x)

    here = kernels.Kernel(far)
    before = here.stamp()
    kept = kernels.norm
    try:
        kernels.norm = inner
        assert here.stamp() != before
    finally:
        kernels.norm = kept
    assert here.stamp() == before


@compiled
def test_products_of_matrices_still_compile_in_the_same_process():
    """Loading kernels leaves out numba's search for BLAS; who needs it must find it all the same."""
    from numba import njit

    matrix(np.array([1.0, 0.0, 0.0, 0.0]))
    product = njit(lambda a, b: a @ b)
    assert np.array_equal(product(np.eye(2), np.full((2, 2), 3.0)), np.full((2, 2), 3.0))


@compiled
def test_loading_does_not_make_ready_to_compile():
    """A process that finds its kernels on disk does without what numba would compile with."""
    program = (
        "import sys, numpy as np\n"
        "from reference_impl.kernels import apply, turned\n"
        "print(apply(np.eye(3), np.ones(3)), turned(np.array((1.0, 0.0, 0.0, 0.0)), np.zeros(3)))\n"
        "print('numba.np.linalg' in sys.modules, 'scipy.linalg' in sys.modules)\n"
    )
    said = [subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout
            for _ in range(2)]  # the first may have to compile them  # fmt: skip
    assert said[1] == "[1. 1. 1.] [1. 0. 0. 0.]\nFalse False\n"


@compiled
@pytest.mark.parametrize("before", [0, 1, 2])
def test_what_is_compiled_beside_a_loaded_caller_can_be_loaded_without(tmp_path, before):
    """Processes that compile at once lose entries of each other's lists of what is kept, as is done here by hand.

    Numba tells functions of a process apart by their number: that of the function compiled anew depends on what was
    compiled before.
    """
    (tmp_path / "pair_of_kernels.py").write_text(
        "from reference_impl.kernels import kernel\n\n"
        "@kernel\ndef twice(x):\n    return 2.0 * x\n\n"
        "@kernel\ndef fourfold(x):\n    return twice(twice(x))\n"
    )
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
        "import numpy as np\n"
        "from numba import njit\n"
        "from pair_of_kernels import fourfold, twice\n"
        "for _ in range(int(sys.argv[1])):\n    njit(lambda x: x)(1.0)\n"
        "print(fourfold(np.ones(2)), twice(np.ones(2)))\n"
    )
    for turn in range(3):
        words = [sys.executable, "-c", program, str(before if turn == 1 else 0)]
        done = subprocess.run(words, check=False, capture_output=True, text=True)
        assert done.stdout == "[4. 4.] [2. 2.]\n", done.stderr
        if turn == 0:
            (kept,) = (tmp_path / "__pycache__").glob("*twice*.nbi")
            kept.unlink()


@compiled
def test_of_processes_that_need_a_kernel_at_once_one_compiles_it(tmp_path):
    """Each says how often it has compiled; without turns each would compile both functions."""
    (tmp_path / "shared_kernels.py").write_text(
        "import math\n\nfrom reference_impl.kernels import kernel\n\n"
        "@kernel\ndef part(x):\n    return math.sin(x) + 1.0\n\n"
        "@kernel\ndef whole(x):\n    s = 0.0\n    for i in range(10):\n        s += part(x + i)\n    return s\n"
    )
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
        "from shared_kernels import part, whole\n"
        "sys.stdin.readline()\n"
        "whole(1.0)\n"
        "print(sum(one.compiled.stats.cache_misses.total() for one in (part, whole)))\n"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    started = [subprocess.Popen([sys.executable, "-c", program], **pipes) for _ in range(3)]
    for one in started:
        one.stdin.write("go\n")
        one.stdin.flush()
    said = [one.communicate(timeout=100)[0] for one in started]
    assert sorted(said) == ["0\n", "0\n", "2\n"]


@compiled
def test_a_turn_ends_with_a_kernel_that_cannot_be_compiled(tmp_path):
    def wrong(x):
        return x.nothing

    here = kernels.Kernel(wrong)
    with pytest.raises(Exception, match="nothing"):
        here(1.0)
    turn = here.compiled._cache.turn
    assert not turn.mine
    turn.folder = str(tmp_path)
    turn.take()
    asks = (
        "import fcntl, sys\n"
        "file = open(sys.argv[1], 'ab')\n"
        "try:\n    fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, int(sys.argv[2]))\n    print('free')\n"
        "except BlockingIOError:\n    print('taken')\n"
    )
    words = [sys.executable, "-c", asks, str(tmp_path / "compiling.lock"), str(turn.byte)]
    taken = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    turn.end()
    free = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert (taken, free) == ("taken\n", "free\n")
