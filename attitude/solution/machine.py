"""How Python is compiled here, and the few machine instructions that Python cannot name.

No fastmath flag is ever set: the error-free transforms rest on the order of every operation, and
results are the same bits whether an epoch is evaluated alone, in an array or in a chunk of one.
For the same reason a product and a sum are fused only where `fma` says so.
"""

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from attitude.solution.cache import kept_on_disk
from attitude.solution.lanes import fused, lanes_among

# Nothing is called through C.
_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}


def compiled(function):
    """Compile at the first call, and keep the machine code on disk where that is possible."""
    return kept_on_disk(function, _OPTIONS)


# Called from compiled code only: part of the caller's cache entry, so it needs none of its own,
# and no door from Python either (that halves the time to compile).
inlined = numba.njit(no_cpython_wrapper=True, **_OPTIONS)
# The same, however long it is: for long code that is called in one place of a loop.
merged = numba.njit(no_cpython_wrapper=True, forceinline=True, **_OPTIONS)


def door(function):
    """Compile for calls from Python, and into the caller where compiled code calls it.

    Left apart from a compiled caller, the process that compiles the two would run a copy of the
    loop that was made before its own callees were known, and which is not vectorised.
    """
    return kept_on_disk(function, {**_OPTIONS, "forceinline": True})


@inlined
def larger(a, b):
    """The larger of two doubles; the builtin max takes ten times as long to compile."""
    return a if a > b else b


def _declare(builder, name, arguments):
    double = ir.DoubleType()
    function = builder.module.declare_intrinsic(name, [double])
    return builder.call(function, arguments)


@intrinsic
def fma(typingctx, a, b, c):
    """a b + c with one rounding; of doubles, and of lanes with doubles among them."""
    kinds = a, b, c
    kind = lanes_among(kinds)
    if kind is not None:
        given = (each if each == kind else types.float64 for each in kinds)
        return kind(*given), lambda context, builder, sig, args: fused(builder, kind, args)

    def codegen(context, builder, signature, arguments):
        double = ir.DoubleType()
        kind = ir.FunctionType(double, [double, double, double])
        function = builder.module.declare_intrinsic("llvm.fma", [double], kind)
        return builder.call(function, arguments)

    f8 = types.float64
    return f8(f8, f8, f8), codegen


@intrinsic
def rint(typingctx, a):
    """The nearest whole number, ties to even, as one instruction."""

    def codegen(context, builder, signature, arguments):
        return _declare(builder, "llvm.rint", arguments)

    return types.float64(types.float64), codegen


@intrinsic
def as_bits(typingctx, a):
    """The 64 bits of a double as a whole number."""

    def codegen(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), codegen


@intrinsic
def from_bits(typingctx, n):
    """The double that has these 64 bits."""

    def codegen(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), codegen
