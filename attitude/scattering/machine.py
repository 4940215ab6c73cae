"""How photometry is compiled: terms of a sum may be taken in any order, products and sums fused.

Other than in `attitude.solution.machine`, no error-free transform is near.  NaN and infinity keep
their meaning.  The choice of instructions then depends on the machine, and the last digits with
it, but not on blocks or threads: an epoch is summed the same way wherever it stands.
"""

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from attitude.solution.cache import kept_on_disk

_OPTIONS = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract", "arcp", "nsz"},
}


def summed(function):
    """Compile at the first call; keep the machine code on disk where that is possible."""
    return kept_on_disk(function, _OPTIONS)


# Called from compiled code, as a function of its own: for what is too long to repeat.
called = numba.njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **_OPTIONS)
# Repeated where it is called: a loop that calls anything is not vectorised (a factor of six).
merged = numba.njit(inline="always", **_OPTIONS)


@intrinsic
def bits_set(typingctx, a):
    """How many bits of a byte are set: one instruction for many bytes where the machine has it."""

    def codegen(context, builder, signature, arguments):
        return builder.ctpop(arguments[0])

    return types.uint8(types.uint8), codegen


@intrinsic
def lowest_bit(typingctx, a):
    """The place of the lowest bit that is set in a word that is not zero."""

    def codegen(context, builder, signature, arguments):
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))

    return types.uint64(types.uint64), codegen
