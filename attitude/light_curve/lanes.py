"""Eight doubles as one value: vector arithmetic where the compiler would not find it by itself.

A loop over eight is unrolled before it could be vectorised.  Here the eight are one number of the
machine's vector type (one AVX-512 register, two of AVX2, four of NEON) that compiled code adds,
multiplies and divides with the usual operators.  Products and sums are fused where the machine
can, as in all of photometry (`attitude.scattering.machine`).
"""

import operator

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, overload, register_model

from attitude.light_curve.clusters import SIZE

_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, SIZE)
_INDEX = ir.IntType(32)


class Lanes(types.Type):
    """Numba's type of eight doubles; only compiled code has values of it."""

    def __init__(self):
        super().__init__("lanes")


_LANES = Lanes()


@register_model(Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _VECTOR)


@intrinsic
def lanes(typingctx, array, i):
    """Eight neighbours array[i], ..., array[i + 7] of a contiguous array of doubles."""

    def codegen(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        here = builder.gep(data, [arguments[1]])
        return builder.load(builder.bitcast(here, _VECTOR.as_pointer()), align=8)

    return _LANES(array, i), codegen


@intrinsic
def spread(typingctx, x):
    """The same double eight times."""

    def codegen(context, builder, signature, arguments):
        none = ir.Constant(_VECTOR, ir.Undefined)
        first = builder.insert_element(none, arguments[0], _INDEX(0))
        return builder.shuffle_vector(first, none, _picked([0] * SIZE))

    return _LANES(types.float64), codegen


@intrinsic
def bits_set_in_bytes(typingctx, word):
    """How many bits are set in each of the eight bytes of a word, the lowest first."""

    def codegen(context, builder, signature, arguments):
        parts = builder.bitcast(arguments[0], ir.VectorType(ir.IntType(8), SIZE))
        counted = ir.FunctionType(parts.type, [parts.type])
        name = f"llvm.ctpop.v{SIZE}i8"
        found = builder.module.globals.get(name) or ir.Function(builder.module, counted, name)
        return builder.uitofp(builder.call(found, [parts]), _VECTOR)

    return _LANES(types.uint64), codegen


@intrinsic
def at_least(typingctx, a, least):
    """The larger of two, lane by lane."""

    def codegen(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered(">", *arguments), *arguments)

    return _LANES(_LANES, _LANES), codegen


@intrinsic
def summed_up(typingctx, a):
    """The sum of the eight, in halves."""

    def codegen(context, builder, signature, arguments):
        (left,) = arguments
        for half in (4, 2, 1):
            low = builder.shuffle_vector(left, left, _picked(range(half)))
            high = builder.shuffle_vector(left, left, _picked(range(half, 2 * half)))
            left = builder.fadd(low, high)
        return builder.extract_element(left, _INDEX(0))

    return types.float64(_LANES), codegen


def _picked(places):
    places = list(places)
    return ir.Constant(ir.VectorType(_INDEX, len(places)), places)


def _with_operator(symbol, instruction):
    @intrinsic
    def applied(typingctx, a, b):
        def codegen(context, builder, signature, arguments):
            return getattr(builder, instruction)(*arguments, flags=("contract", "nsz"))

        return _LANES(_LANES, _LANES), codegen

    @overload(symbol, inline="always")
    def of_lanes(a, b):
        if isinstance(a, Lanes) and isinstance(b, Lanes):
            return lambda a, b: applied(a, b)
        return None


_with_operator(operator.add, "fadd")
_with_operator(operator.mul, "fmul")
_with_operator(operator.truediv, "fdiv")
