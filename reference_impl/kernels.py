"""Compiled vector and rotation arithmetic, and how a function becomes compiled.

Everything the engine computes many times a step is a `kernel`: compiled on first use and kept on disk.
No fast-math and no threads: the same input gives the same bits.  With NUMBA_DISABLE_JIT=1 the same
functions run as plain Python.

Numba on its own keeps compiled code as long as the file a function stands in is unchanged, and does not see
that a function it calls, in another file, is another one now.  Here it is kept as long as the code of the
function and of everything it refers to, however far down, is the same; only what has changed is compiled anew.
Of several processes that need the same one compiles it, and the others wait and load.
"""

from __future__ import annotations

import functools
import hashlib
import math
from collections.abc import Callable, Iterator
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numba import njit, types
from numba.core import config
from numba.core.typing.typeof import typeof_impl

from reference_impl.compiled_code import Kept, in_turn


class Kernel:
    """A function that is compiled, or loaded from disk, when it is called for the first time.

    A kernel that only other kernels call costs nothing once these are on disk.

    Parameters
    ----------
    function : function
    within : bool
        Whether its code becomes part of every kernel that calls it.
    lean : bool
        Whether it only works in arrays that it is given: no references to them are counted then, and numba refuses
        to compile what makes arrays of its own.
    """

    def __init__(self, function: FunctionType, within: bool = False, lean: bool = False) -> None:
        functools.update_wrapper(self, function)
        self.function, self.within, self.lean = function, within, lean

    def __call__(self, *args: Any) -> Any:
        return self.compiled(*args)

    @functools.cached_property
    def compiled(self) -> Callable[..., Any]:
        """Numba's dispatcher of the function."""
        # nobody calls kernels from C: the wrapper for that would be a twentieth of the time to compile
        dispatcher = njit(
            error_model="numpy", forceinline=self.within, no_cfunc_wrapper=True, _nrt=not self.lean
        )(self.function)  # fmt: skip
        dispatcher.get_call_template = functools.partial(_for_any_constant, dispatcher.get_call_template)
        dispatcher._cache = Kept(self.function)
        dispatcher._cache._cache_file._source_stamp = self.stamp()
        dispatcher.compile = functools.partial(in_turn, dispatcher.compile, dispatcher._cache)
        return dispatcher

    def stamp(self) -> str:
        """Digest of the code of this function and of everything it refers to."""
        found = [self]
        digest = hashlib.sha256()
        for one in found:  # grows on the way
            digest.update(one.function.__qualname__.encode() + (b" lean" if one.lean else b""))
            for code in _codes(one.function.__code__):
                digest.update(code.co_code)
                digest.update(repr([c for c in code.co_consts if not isinstance(c, CodeType)]).encode())
            for name, value in _references(one.function):
                if isinstance(value, Kernel) and value not in found:
                    found.append(value)
                digest.update(f"{name} {_said(value)}".encode())
        return digest.hexdigest()


kernel: Callable[[Any], Any] = (lambda function: function) if config.DISABLE_JIT else Kernel
# for the smallest: a call would hand over every array as a dozen numbers, which costs more than what they do
inlined: Callable[[Any], Any] = kernel if config.DISABLE_JIT else functools.partial(Kernel, within=True, lean=True)
# for loops of many small calls: counting who holds which array takes a third of the time of such a loop
lean: Callable[[Any], Any] = kernel if config.DISABLE_JIT else functools.partial(Kernel, lean=True)


@typeof_impl.register(Kernel)
def _type_of_kernel(value: Kernel, context: object) -> types.Type:
    """A kernel that another one calls is to numba what its dispatcher is."""
    return types.Dispatcher(value.compiled)


def _for_any_constant(template: Callable[..., Any], args: Any, kws: Any) -> Any:
    """How a kernel calls another one: as one compiled for the types of its arguments, not for constants among them.

    Numba on its own compiles f(0), f(1) and f(i) one after the other.
    """
    general = {name: types.unliteral(kind) for name, kind in kws.items()}
    return template(tuple(types.unliteral(kind) for kind in args), general)


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code and that of the functions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _references(function: FunctionType) -> Iterator[tuple[str, object]]:
    """Names and values a function refers to outside itself: globals, attributes of modules, enclosing variables."""
    names = sorted({name for code in _codes(function.__code__) for name in code.co_names})
    for name in names:
        if name in function.__globals__:
            value = function.__globals__[name]
            yield name, value
            if isinstance(value, ModuleType) and value.__name__.startswith("reference_impl"):
                yield from ((other, getattr(value, other)) for other in names if hasattr(value, other))
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        yield name, cell.cell_contents


def _said(value: object) -> str:
    """What tells a constant from another one of its kind; functions and modules by name."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype.str}{value.shape}{value.tobytes().hex()}"
    return getattr(value, "__qualname__", None) or getattr(value, "__name__", None) or repr(value)


@kernel
def dot(a, b):
    """a·b of two 3-vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def norm(a):
    """Length of a 3-vector."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@kernel
def minus(a, b):
    """a - b of two 3-vectors; `a - b` itself makes numba compile a loop over shapes at every place it stands."""
    out = np.empty(3)
    for c in range(3):
        out[c] = a[c] - b[c]
    return out


@kernel
def along(a, s, b):
    """a + s b of two 3-vectors and a number."""
    out = np.empty(3)
    for c in range(3):
        out[c] = a[c] + s * b[c]
    return out


@kernel
def cross(a, b):
    """a × b."""
    out = np.empty(3)
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


@kernel
def apply(m, a):
    """Matrix times vector, m a."""
    out = np.empty(3)
    for i in range(3):
        out[i] = m[i, 0] * a[0] + m[i, 1] * a[1] + m[i, 2] * a[2]
    return out


@kernel
def apply_transposed(m, a):
    """Transposed matrix times vector, mᵀ a: the world vector a in the frame whose axes are m's columns."""
    out = np.empty(3)
    for i in range(3):
        out[i] = m[0, i] * a[0] + m[1, i] * a[1] + m[2, i] * a[2]
    return out


@kernel
def matrix(q):
    """Rotation matrix of the quaternion q, which need not have unit length: columns are the body axes in the world."""
    s = 2.0 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    w, x, y, z = q[0], q[1], q[2], q[3]
    m = np.empty((3, 3))
    m[0, 0] = 1.0 - s * (y * y + z * z)
    m[0, 1] = s * (x * y - w * z)
    m[0, 2] = s * (x * z + w * y)
    m[1, 0] = s * (x * y + w * z)
    m[1, 1] = 1.0 - s * (x * x + z * z)
    m[1, 2] = s * (y * z - w * x)
    m[2, 0] = s * (x * z - w * y)
    m[2, 1] = s * (y * z + w * x)
    m[2, 2] = 1.0 - s * (x * x + y * y)
    return m


@kernel
def turned(q, angle):
    """Quaternion of the attitude q turned further by the world rotation vector `angle` [rad], of unit length."""
    half = 0.5 * norm(angle)
    c = math.cos(half)
    s = 0.5 if half == 0.0 else 0.5 * math.sin(half) / half
    x, y, z = s * angle[0], s * angle[1], s * angle[2]
    out = np.empty(4)
    out[0] = c * q[0] - x * q[1] - y * q[2] - z * q[3]
    out[1] = c * q[1] + x * q[0] + y * q[3] - z * q[2]
    out[2] = c * q[2] - x * q[3] + y * q[0] + z * q[1]
    out[3] = c * q[3] + x * q[2] - y * q[1] + z * q[0]
    size = math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2] + out[3] * out[3])
    for c in range(4):
        out[c] /= size
    return out


@kernel
def spin_rate(q, w):
    """Derivative of q under the world angular velocity w, q' = ½ ω q [1/s]."""
    out = np.empty(4)
    out[0] = -0.5 * (w[0] * q[1] + w[1] * q[2] + w[2] * q[3])
    out[1] = 0.5 * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2])
    out[2] = 0.5 * (-w[0] * q[3] + w[1] * q[0] + w[2] * q[1])
    out[3] = 0.5 * (w[0] * q[2] - w[1] * q[1] + w[2] * q[0])
    return out


@kernel
def angular_velocity(q, rate):
    """World angular velocity of an attitude q that changes at `rate`, ω = 2 q' q⁻¹ [rad/s]."""
    size = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]
    s = 2.0 / size
    out = np.empty(3)
    out[0] = s * (-rate[0] * q[1] + rate[1] * q[0] - rate[2] * q[3] + rate[3] * q[2])
    out[1] = s * (-rate[0] * q[2] + rate[1] * q[3] + rate[2] * q[0] - rate[3] * q[1])
    out[2] = s * (-rate[0] * q[3] - rate[1] * q[2] + rate[2] * q[1] + rate[3] * q[0])
    return out


@kernel
def spin(rotation, inverse_inertia, momentum):
    """Angular velocity R I⁻¹ Rᵀ L of the angular momentum L, world frame [rad/s]; I⁻¹ in the body frame."""
    return apply(rotation, apply(inverse_inertia, apply_transposed(rotation, momentum)))
