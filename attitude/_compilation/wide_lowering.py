"""The instructions of `wide` for numba; imported when the first function is compiled."""

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.extending import lower_builtin, models, register_model, type_callable

from attitude._compilation import wide
from attitude._compilation.simd_lowering import instruction

_SIZE = 64 * wide.WORDS
_WIDE = ir.IntType(_SIZE)
_PRODUCT = ir.IntType(2 * _SIZE)
_BIT = ir.IntType(1)
_WORD = ir.IntType(64)
_TWO = ir.IntType(128)
_THREE = ir.IntType(192)
_DOUBLE = ir.DoubleType()
_WORDS = wide.WORDS


class WideType(types.Type):
    """numba's type of a whole number of 448 bits; only compiled code has values of it."""

    def __init__(self) -> None:
        super().__init__("wide")


_KIND = WideType()


@register_model(WideType)
class _WideModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _WIDE)


@instruction(wide.wide, _KIND(types.int64))
def _wide(context, builder, signature, arguments):
    return builder.sext(arguments[0], _WIDE)


@instruction(wide.word, types.int64(_KIND))
def _low_word(context, builder, signature, arguments):
    return builder.trunc(arguments[0], _WORD)


@instruction(wide.whole, _KIND(types.float64))
def _whole(context, builder, signature, arguments):
    bits = builder.bitcast(arguments[0], _WORD)
    exponent = builder.and_(builder.lshr(bits, _WORD(52)), _WORD(0x7FF))
    fraction = builder.or_(builder.and_(bits, _WORD((1 << 52) - 1)), _WORD(1 << 52))
    places = builder.sub(exponent, _WORD(1075))
    up = builder.icmp_signed(">=", places, _WORD(0))
    left = builder.select(up, places, _WORD(0))
    right = builder.select(up, _WORD(0), builder.sub(_WORD(0), places))
    right = builder.select(builder.icmp_unsigned("<", right, _WORD(63)), right, _WORD(63))
    size = builder.zext(builder.lshr(fraction, right), _WIDE)
    size = builder.shl(size, builder.zext(left, _WIDE))
    below = builder.icmp_signed("<", bits, _WORD(0))
    return builder.select(below, builder.sub(_WIDE(0), size), size)


def _magnitude(builder, n):
    below = builder.icmp_signed("<", n, _WIDE(0))
    return below, builder.select(below, builder.sub(_WIDE(0), n), n)


@instruction(wide.double, types.float64(_KIND))
def _double(context, builder, signature, arguments):
    below, size = _magnitude(builder, arguments[0])
    zeros = builder.ctlz(size, _BIT(0))  # all bits of zero
    none = builder.icmp_unsigned("==", size, _WIDE(0))
    shift = builder.select(none, _WIDE(0), zeros)
    upright = builder.shl(size, shift)
    high = builder.trunc(builder.lshr(upright, _WIDE(_SIZE - 64)), _WORD)
    # what is below the upper word decides a tie: 64 bits are more than the 53 of a double
    sticky = builder.icmp_unsigned("!=", builder.shl(upright, _WIDE(64)), _WIDE(0))
    double = builder.uitofp(builder.or_(high, builder.zext(sticky, _WORD)), _DOUBLE)
    power = builder.sub(_WORD(1023 + _SIZE - 64), builder.trunc(shift, _WORD))
    double = builder.fmul(double, builder.bitcast(builder.shl(power, _WORD(52)), _DOUBLE))
    return builder.select(below, builder.fneg(double), double)


def _multiplied(builder, arguments, first):
    """The magnitude of a product without the words of places below `first`, and its sign.

    Place by place: the sum of a place does not wait for the carries of the place before, as that of
    a row does, which takes twice as long.
    """
    signs, parts = zip(*(_magnitude(builder, argument) for argument in arguments), strict=True)
    a, b = ([_word(builder, n, k) for k in range(_WORDS)] for n in parts)
    total, place = _PRODUCT(0), _THREE(0)
    for k in range(first, 2 * _WORDS):
        for i in range(max(k - _WORDS + 1, 0), min(k + 1, _WORDS)):
            product = builder.mul(builder.zext(a[i], _TWO), builder.zext(b[k - i], _TWO))
            place = builder.add(place, builder.zext(product, _THREE))
        word = builder.zext(builder.trunc(place, _WORD), _PRODUCT)
        total = builder.or_(total, builder.shl(word, _PRODUCT(64 * k)))
        place = builder.lshr(place, _THREE(64))
    return total, builder.xor(*signs)


@instruction(wide.times, _KIND(_KIND, _KIND))
def _times(context, builder, signature, arguments):
    total, below = _multiplied(builder, arguments, 0)
    total = builder.select(below, builder.sub(_PRODUCT(0), total), total)
    total = builder.add(total, _PRODUCT(1 << (wide.BITS - 1)))
    return builder.trunc(builder.ashr(total, _PRODUCT(wide.BITS)), _WIDE)


@instruction(wide.product, _KIND(_KIND, _KIND))
def _product(context, builder, signature, arguments):
    total, below = _multiplied(builder, arguments, wide.FIRST)
    size = builder.trunc(builder.lshr(total, _PRODUCT(wide.BITS)), _WIDE)
    return builder.select(below, builder.sub(_WIDE(0), size), size)


def _word(builder, n, k):
    return builder.trunc(builder.lshr(n, _WIDE(64 * k)), _WORD)


@instruction(wide.shifted, _KIND(_KIND, types.int64))
def _shifted(context, builder, signature, arguments):
    n, places = arguments
    left = builder.icmp_signed(">=", places, _WORD(0))
    size = builder.select(left, places, builder.sub(_WORD(0), places))
    size = builder.zext(size, _WIDE)
    return builder.select(left, builder.shl(n, size), builder.ashr(n, size))


@instruction(wide.negative, types.boolean(_KIND))
def _negative(context, builder, signature, arguments):
    below = builder.icmp_signed("<", arguments[0], _WIDE(0))
    return context.cast(builder, below, types.boolean, signature.return_type)


@instruction(wide.length, types.int64(_KIND))
def _length(context, builder, signature, arguments):
    _, size = _magnitude(builder, arguments[0])
    zeros = builder.trunc(builder.ctlz(size, _BIT(0)), _WORD)
    return builder.sub(_WORD(_SIZE), zeros)


def _place(context, builder, kind, array, k):
    """The pointer to the k-th wide number of an array of words."""
    data = context.make_array(kind)(context, builder, array).data
    pointer = builder.gep(data, [builder.mul(k, _WORD(_WORDS))])
    return builder.bitcast(pointer, _WIDE.as_pointer())


@instruction(wide.load, lambda words, k: _KIND(words, types.int64))
def _load(context, builder, signature, arguments):
    return builder.load(_place(context, builder, signature.args[0], *arguments), align=8)


@instruction(wide.store, lambda words, k, n: types.void(words, types.int64, _KIND))
def _store(context, builder, signature, arguments):
    place = _place(context, builder, signature.args[0], *arguments[:2])
    builder.store(arguments[2], place, align=8)
    return context.get_dummy_value()


def _operator(symbol, instruction):
    """Register the instruction of an operator on two wide numbers."""

    @type_callable(symbol)
    def of_context(context):
        return lambda a, b: _KIND(_KIND, _KIND) if a == b == _KIND else None

    @lower_builtin(symbol, WideType, WideType)
    def lowered(context, builder, signature, arguments):
        return getattr(builder, instruction)(*arguments)


def register_wide() -> None:
    """Register the operators; importing this module has registered the functions of `wide`."""
    _operator(operator.add, "add")
    _operator(operator.sub, "sub")
