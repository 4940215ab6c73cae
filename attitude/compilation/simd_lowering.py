"""The vector instructions of `simd` for numba; imported when the first function is compiled."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import lower_builtin, models, register_model, type_callable

from attitude.compilation import error_free, simd
from attitude.compilation.error_free import is_instruction

_DOUBLE = ir.DoubleType()
_INDEX = ir.IntType(32)


class LanesType(types.Type):
    """numba's type of a SIMD vector of `count` doubles; only compiled code has values of it."""

    def __init__(self, count: int) -> None:
        self.count = count
        super().__init__(f"lanes({count})")

    @property
    def vector(self) -> ir.VectorType:
        """LLVM's type of the vector."""
        return ir.VectorType(_DOUBLE, self.count)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, kind.vector)


def _typed(function):
    """Register a typer: a function from the argument types of a function of `simd` to its type."""

    def register(typer):
        @type_callable(function)
        def of_context(context):
            return typer

        return typer

    return register


def _lowered(function):
    """Register the instructions of a function of `simd`."""
    return lower_builtin(function, types.VarArg(types.Any))


@_typed(simd.eight)
def _eight_type(array, i):
    return LanesType(8)


@_typed(simd.four)
def _four_type(array, i):
    return LanesType(4)


@_lowered(simd.four)
@_lowered(simd.eight)
def _eight(context, builder, signature, arguments):
    kind = signature.return_type
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    here = builder.gep(data, [arguments[1]])
    return builder.load(builder.bitcast(here, kind.vector.as_pointer()), align=8)


@_typed(simd.put_eight)
def _put_eight_type(array, i, numbers):
    return types.void(array, types.intp, numbers)


@_lowered(simd.put_eight)
def _put_eight(context, builder, signature, arguments):
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    here = builder.gep(data, [arguments[1]])
    numbers = arguments[2]
    builder.store(numbers, builder.bitcast(here, numbers.type.as_pointer()), align=8)
    return context.get_dummy_value()


@_typed(simd.lanes)
def _lanes_type(numbers):
    return LanesType(len(numbers))


@_lowered(simd.lanes)
def _lanes(context, builder, signature, arguments):
    kind = signature.return_type
    made = ir.Constant(kind.vector, ir.Undefined)
    for k in range(kind.count):
        one = builder.extract_value(arguments[0], k)
        made = builder.insert_element(made, one, _INDEX(k))
    return made


@_typed(simd.doubles_of)
def _doubles_type(a):
    return types.UniTuple(types.float64, a.count)


@_lowered(simd.doubles_of)
def _doubles(context, builder, signature, arguments):
    count = range(signature.return_type.count)
    found = [builder.extract_element(arguments[0], _INDEX(k)) for k in count]
    return context.make_tuple(builder, signature.return_type, found)


@_typed(simd.bits_set_in_bytes)
def _bits_type(word):
    return LanesType(8)(types.uint64)


@_lowered(simd.bits_set_in_bytes)
def _bits(context, builder, signature, arguments):
    kind = signature.return_type
    parts = builder.bitcast(arguments[0], ir.VectorType(ir.IntType(8), kind.count))
    counted = builder.call(_function(builder, "llvm.ctpop.v8i8", parts.type, 1), [parts])
    return builder.uitofp(counted, kind.vector)


@_typed(simd.at_least)
def _at_least_type(a, least):
    return a


@_lowered(simd.at_least)
def _at_least(context, builder, signature, arguments):
    return builder.select(builder.fcmp_ordered(">", *arguments), *arguments)


@_typed(simd.at_most)
def _at_most_type(a, most):
    return a


@_lowered(simd.at_most)
def _at_most(context, builder, signature, arguments):
    return builder.select(builder.fcmp_ordered("<", *arguments), *arguments)


@_typed(simd.chosen)
def _chosen_type(by, a, b):
    return a


@_lowered(simd.chosen)
def _chosen(context, builder, signature, arguments):
    return builder.select(_above_zero(builder, arguments[0]), *arguments[1:])


@_typed(simd.root)
def _root_type(a):
    return a


@_lowered(simd.root)
def _root(context, builder, signature, arguments):
    kind = signature.return_type
    function = _function(builder, f"llvm.sqrt.v{kind.count}f64", kind.vector, 1)
    return builder.call(function, arguments)


@_typed(simd.summed_up)
def _summed_type(a):
    return types.float64


@_lowered(simd.summed_up)
def _summed_up(context, builder, signature, arguments):
    (left,) = arguments
    half = signature.args[0].count // 2
    while half:
        low = builder.shuffle_vector(left, left, _picked(range(half)))
        high = builder.shuffle_vector(left, left, _picked(range(half, 2 * half)))
        left = builder.fadd(low, high)
        half //= 2
    return builder.extract_element(left, _INDEX(0))


@_typed(simd.largest_lane)
def _largest_type(a):
    return types.float64


@_lowered(simd.largest_lane)
def _largest(context, builder, signature, arguments):
    (left,) = arguments
    half = signature.args[0].count // 2
    while half:
        pair = [builder.shuffle_vector(left, left, _picked(range(k, k + half))) for k in (0, half)]
        left = builder.select(builder.fcmp_ordered(">", *pair), *pair)
        half //= 2
    return builder.extract_element(left, _INDEX(0))


@_typed(simd.positive_bits)
def _positive_type(a):
    return types.int64


@_lowered(simd.positive_bits)
def _positive(context, builder, signature, arguments):
    above = builder.bitcast(_above_zero(builder, arguments[0]), ir.IntType(signature.args[0].count))
    return builder.zext(above, ir.IntType(64))


def _above_zero(builder, x):
    return builder.fcmp_ordered(">", x, ir.Constant(x.type, [0.0] * x.type.count))


def fused(builder: Any, kind: LanesType, arguments: Sequence[Any]) -> Any:
    """The instruction for a b + c with one rounding, of vectors and doubles."""
    arguments = [_spread(builder, kind, each) for each in arguments]
    if not is_instruction("llvm.fma", 3):
        return error_free.fma(builder, *arguments)
    function = _function(builder, f"llvm.fma.v{kind.count}f64", kind.vector, 3)
    return builder.call(function, arguments)


def lanes_among(kinds: Iterable[Any]) -> LanesType | None:
    """The one type of the vectors among the operands, the others being doubles; else None."""
    found = {kind for kind in kinds if isinstance(kind, LanesType)}
    others = [kind for kind in kinds if not isinstance(kind, (LanesType, types.Float))]
    return found.pop() if len(found) == 1 and not others else None


def _function(builder, name, kind, count):
    """LLVM's function of that name, of `count` values of a type to one."""
    found = builder.module.globals.get(name)
    return found or ir.Function(builder.module, ir.FunctionType(kind, [kind] * count), name)


def _spread(builder, kind, x):
    """A double in every lane; a vector unchanged."""
    if x.type == kind.vector:
        return x
    none = ir.Constant(kind.vector, ir.Undefined)
    first = builder.insert_element(none, x, _INDEX(0))
    return builder.shuffle_vector(first, none, _picked([0] * kind.count))


def _picked(places):
    """The mask of a shuffle: the number of the lane that each lane is taken from."""
    places = list(places)
    return ir.Constant(ir.VectorType(_INDEX, len(places)), places)


def _operator(symbol, instruction):
    """Register the instruction of an operator on vectors, and on a vector and a double."""

    @_typed(symbol)
    def typer(a, b):
        kind = lanes_among((a, b))
        return kind and kind(*(each if each == kind else types.float64 for each in (a, b)))

    def applied(context, builder, signature, arguments):
        kind = signature.return_type
        return getattr(builder, instruction)(*(_spread(builder, kind, a) for a in arguments))

    for pair in ((LanesType, LanesType), (LanesType, types.Float), (types.Float, LanesType)):
        lower_builtin(symbol, *pair)(applied)


_operator(operator.add, "fadd")
_operator(operator.sub, "fsub")
_operator(operator.mul, "fmul")
_operator(operator.truediv, "fdiv")
