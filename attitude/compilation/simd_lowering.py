"""The vector instructions of `simd` for numba; imported when the first function is compiled."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
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


def typed(function: Callable[..., Any]) -> Callable[..., Any]:
    """Register a typer: a function from the argument types of a function of `simd` to its type."""

    def register(typer):
        @type_callable(function)
        def of_context(context):
            return typer

        return typer

    return register


def lowered(function: Callable[..., Any]) -> Callable[..., Any]:
    """Register the instructions of a function of `simd`."""
    return lower_builtin(function, types.VarArg(types.Any))


@typed(simd.lanes)
def _lanes_type(numbers):
    return LanesType(len(numbers))


@lowered(simd.lanes)
def _lanes(context, builder, signature, arguments):
    kind = signature.return_type
    made = ir.Constant(kind.vector, ir.Undefined)
    for k in range(kind.count):
        one = builder.extract_value(arguments[0], k)
        made = builder.insert_element(made, one, _INDEX(k))
    return made


@typed(simd.doubles_of)
def _doubles_type(a):
    return types.UniTuple(types.float64, a.count)


@lowered(simd.doubles_of)
def _doubles(context, builder, signature, arguments):
    count = range(signature.return_type.count)
    found = [builder.extract_element(arguments[0], _INDEX(k)) for k in count]
    return context.make_tuple(builder, signature.return_type, found)


@typed(simd.bits_set_in_bytes)
def _bits_type(word):
    return LanesType(8)(types.uint64)


@lowered(simd.bits_set_in_bytes)
def _bits(context, builder, signature, arguments):
    kind = signature.return_type
    parts = builder.bitcast(arguments[0], ir.VectorType(ir.IntType(8), kind.count))
    counted = builder.call(function_named(builder, "llvm.ctpop.v8i8", parts.type, 1), [parts])
    return builder.uitofp(counted, kind.vector)


@typed(simd.every)
def _every_type(number, like):
    return like(types.float64, like)


@lowered(simd.every)
def _every_lane(context, builder, signature, arguments):
    return _spread(builder, signature.return_type, arguments[0])


@typed(simd.at_least)
def _at_least_type(a, least):
    return a


@lowered(simd.at_least)
def _at_least(context, builder, signature, arguments):
    arguments = [_spread(builder, signature.return_type, each) for each in arguments]
    return builder.select(builder.fcmp_ordered(">", *arguments), *arguments)


@typed(simd.at_most)
def _at_most_type(a, most):
    return a


@lowered(simd.at_most)
def _at_most(context, builder, signature, arguments):
    arguments = [_spread(builder, signature.return_type, each) for each in arguments]
    return builder.select(builder.fcmp_ordered("<", *arguments), *arguments)


@typed(simd.chosen)
def _chosen_type(by, a, b):
    return a


@lowered(simd.chosen)
def _chosen(context, builder, signature, arguments):
    return builder.select(_above_zero(builder, arguments[0]), *arguments[1:])


@typed(simd.root)
def _root_type(a):
    return a


@lowered(simd.root)
def _root(context, builder, signature, arguments):
    kind = signature.return_type
    if not isinstance(kind, LanesType):
        return builder.call(function_named(builder, "llvm.sqrt.f64", _DOUBLE, 1), arguments)
    function = function_named(builder, f"llvm.sqrt.v{kind.count}f64", kind.vector, 1)
    return builder.call(function, arguments)


@typed(simd.packed)
def _packed_type(a, by):
    return a


@lowered(simd.packed)
def _packed(context, builder, signature, arguments):
    kind, mask = signature.return_type.vector, _above_zero(builder, arguments[1])
    shape = ir.FunctionType(kind, [kind, mask.type, kind])
    name = f"llvm.experimental.vector.compress.v{kind.count}f64"
    function = builder.module.globals.get(name) or ir.Function(builder.module, shape, name)
    return builder.call(function, [arguments[0], mask, ir.Constant(kind, [0.0] * kind.count)])


@typed(simd.largest_lane)
@typed(simd.summed_up)
def _one_lane_type(a):
    return types.float64


@lowered(simd.summed_up)
def _summed_up(context, builder, signature, arguments):
    return builder.extract_element(_added(builder, arguments[0], 1), _INDEX(0))


@typed(simd.summed_for_each)
def _summed_for_each_type(a, like):
    return like(a, like)


@lowered(simd.summed_for_each)
def _summed_for_each(context, builder, signature, arguments):
    kind = signature.return_type
    if isinstance(kind, LanesType):
        return _added(builder, arguments[0], kind.count)
    return builder.extract_element(_added(builder, arguments[0], 1), _INDEX(0))


def _added(builder, left, count):
    """The upper half of the lanes is added to the lower one until so many are left."""
    while left.type.count > count:
        half = left.type.count // 2
        low = builder.shuffle_vector(left, left, _picked(range(half)))
        high = builder.shuffle_vector(left, left, _picked(range(half, 2 * half)))
        left = builder.fadd(low, high)
    return left


@typed(simd.for_each)
def _for_each_type(numbers, like):
    return LanesType(len(numbers) * (like.count if isinstance(like, LanesType) else 1))


@lowered(simd.for_each)
def _for_each(context, builder, signature, arguments):
    kind = signature.return_type
    made, count = ir.Constant(kind.vector, ir.Undefined), kind.count // len(signature.args[0])
    for k in range(kind.count):
        one = builder.extract_value(arguments[0], k // count)
        made = builder.insert_element(made, one, _INDEX(k))
    return made


@lowered(simd.largest_lane)
def _largest(context, builder, signature, arguments):
    (left,) = arguments
    half = signature.args[0].count // 2
    while half:
        pair = [builder.shuffle_vector(left, left, _picked(range(k, k + half))) for k in (0, half)]
        left = builder.select(builder.fcmp_ordered(">", *pair), *pair)
        half //= 2
    return builder.extract_element(left, _INDEX(0))


@typed(simd.positive_bits)
def _positive_type(a):
    return types.int64


@lowered(simd.positive_bits)
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
    function = function_named(builder, f"llvm.fma.v{kind.count}f64", kind.vector, 3)
    return builder.call(function, arguments)


def lanes_among(kinds: Iterable[Any]) -> LanesType | None:
    """The type of the longest vectors among the operands, the others being doubles; else None."""
    kinds = list(kinds)
    found = [kind for kind in kinds if isinstance(kind, LanesType)]
    others = [kind for kind in kinds if not isinstance(kind, (LanesType, types.Float))]
    return max(found, key=lambda kind: kind.count) if found and not others else None


def operands(given: Iterable[Any]) -> Iterable[Any]:
    """The types as which an operator takes its operands: vectors as they are, else doubles."""
    return (each if isinstance(each, LanesType) else types.float64 for each in given)


def function_named(builder: Any, name: str, kind: Any, count: int) -> Any:
    """LLVM's function of that name, of `count` values of a type to one."""
    found = builder.module.globals.get(name)
    return found or ir.Function(builder.module, ir.FunctionType(kind, [kind] * count), name)


def _spread(builder, kind, x):
    """A double in every lane; a vector unchanged, or a shorter one repeated."""
    if x.type == kind.vector:
        return x
    if isinstance(x.type, ir.VectorType):
        places = [k % x.type.count for k in range(kind.count)]
        return builder.shuffle_vector(x, x, _picked(places))
    none = ir.Constant(kind.vector, ir.Undefined)
    first = builder.insert_element(none, x, _INDEX(0))
    return builder.shuffle_vector(first, none, _picked([0] * kind.count))


def _picked(places):
    """The mask of a shuffle: the number of the lane that each lane is taken from."""
    places = list(places)
    return ir.Constant(ir.VectorType(_INDEX, len(places)), places)


def _operator(symbol, instruction):
    """Register the instruction of an operator on vectors, and on a vector and a double."""

    @typed(symbol)
    def typer(a, b):
        kind = lanes_among((a, b))
        return kind and kind(*operands((a, b)))

    def applied(context, builder, signature, arguments):
        kind = signature.return_type
        return getattr(builder, instruction)(*(_spread(builder, kind, a) for a in arguments))

    for pair in ((LanesType, LanesType), (LanesType, types.Float), (types.Float, LanesType)):
        lower_builtin(symbol, *pair)(applied)


_operator(operator.add, "fadd")
_operator(operator.sub, "fsub")
_operator(operator.mul, "fmul")
_operator(operator.truediv, "fdiv")


@typed(operator.neg)
def _negative_type(a):
    return a if isinstance(a, LanesType) else None


@lower_builtin(operator.neg, LanesType)
def _negative(context, builder, signature, arguments):
    return builder.fneg(arguments[0])
