"""The instructions of `simd` on exponents and whole numbers; imported with `simd_lowering`."""

from __future__ import annotations

from llvmlite import ir

from attitude.compilation import simd
from attitude.compilation.simd_lowering import function_named, lowered, typed

_DOUBLE = ir.DoubleType()
_INDEX = ir.IntType(32)

# Adding these leaves a whole number below 2^51, or one of eighths below 2^48, in the low bits.
_WHOLE, _EIGHTHS = 3.0 * 2.0**51, 3.0 * 2.0**48


@typed(simd.truncated)
def _truncated_type(a):
    return a


@lowered(simd.truncated)
def _truncated(context, builder, signature, arguments):
    kind = signature.return_type
    whole = builder.fptosi(arguments[0], ir.VectorType(_INDEX, kind.count))
    return builder.sitofp(whole, kind.vector)


@typed(simd.nearest_eighth)
def _nearest_type(a):
    return a


@lowered(simd.nearest_eighth)
def _nearest_eighth(context, builder, signature, arguments):
    kind = signature.return_type
    total = _in_low_bits(builder, kind, arguments[0], _EIGHTHS)
    return _fenced(builder, kind, builder.fsub(total, _all(kind, _EIGHTHS)))


@typed(simd.inverse_power)
def _power_type(a):
    return a


@lowered(simd.inverse_power)
def _inverse_power(context, builder, signature, arguments):
    kind = signature.return_type
    integers = ir.VectorType(ir.IntType(64), kind.count)
    low = builder.bitcast(_in_low_bits(builder, kind, arguments[0], _EIGHTHS), integers)
    place = builder.and_(low, ir.Constant(integers, [7] * kind.count))
    table = ir.Constant(ir.VectorType(_DOUBLE, 8), [2.0 ** (-k / 8.0) for k in range(8)])
    power = ir.Constant(kind.vector, ir.Undefined)
    # LLVM makes one permutation of eight such lanes where the processor has it.
    for k in range(kind.count):
        one = builder.extract_element(table, builder.extract_element(place, _INDEX(k)))
        power = builder.insert_element(power, one, _INDEX(k))
    whole = builder.shl(builder.sub(low, place), ir.Constant(integers, [49] * kind.count))
    return builder.bitcast(builder.sub(builder.bitcast(power, integers), whole), kind.vector)


@typed(simd.halved)
def _halved_type(a, times):
    return a


@lowered(simd.halved)
def _halved(context, builder, signature, arguments):
    kind = signature.return_type
    integers = ir.VectorType(ir.IntType(64), kind.count)
    times = builder.bitcast(_in_low_bits(builder, kind, arguments[1], _WHOLE), integers)
    shifted = builder.shl(times, ir.Constant(integers, [52] * kind.count))
    bits = builder.sub(builder.bitcast(arguments[0], integers), shifted)
    return builder.bitcast(bits, kind.vector)


@typed(simd.exponent)
def _exponent_type(a):
    return a


@lowered(simd.exponent)
def _exponent(context, builder, signature, arguments):
    kind = signature.return_type
    integers = ir.VectorType(ir.IntType(64), kind.count)
    # the bits of 3/4, by which the exponents of 3/4 to 3/2 become zero
    first = ir.Constant(integers, [0x3FE8 << 48] * kind.count)
    above = builder.sub(builder.bitcast(arguments[0], integers), first)
    shifted = builder.ashr(above, ir.Constant(integers, [52] * kind.count))
    return builder.sitofp(shifted, kind.vector)


def _in_low_bits(builder, kind, a, number):
    """The sum with a number that rounds to a multiple of a power of two in the low bits."""
    return _fenced(builder, kind, builder.fadd(a, _all(kind, number)))


def _fenced(builder, kind, a):
    """The vector, across which the compiler does not reorder sums."""
    name = f"llvm.arithmetic.fence.v{kind.count}f64"
    return builder.call(function_named(builder, name, kind.vector, 1), [a])


def _all(kind, number):
    return ir.Constant(kind.vector, [number] * kind.count)
