"""The vector instructions of `simd` for numba.

It is imported when the first function is compiled.
"""

from __future__ import annotations

import inspect
import operator
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from llvmlite.binding import llvm_version_info
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, models, register_model, type_callable

from attitude._compilation import error_free, simd
from attitude._compilation.error_free import constant, is_instruction, like

_DOUBLE = ir.DoubleType()
_INDEX = ir.IntType(32)
_INTEGER = ir.IntType(64)
# LLVM has `llvm.experimental.vector.compress` from this version on.  An earlier one takes the name
# for a function of another library, whose address is zero.
_COMPRESSES = 19


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


def instruction(function: Callable[..., Any], kind: Any) -> Callable[..., Any]:
    """Register the types of a function, a signature or a typer, and the instructions of it.

    A typer makes the type, or the signature, from the types of the arguments.
    """

    def typer(*arguments: Any) -> Any:
        return kind(*arguments) if inspect.isfunction(kind) else kind

    typer.pysig = inspect.signature(function)  # type: ignore[attr-defined]
    type_callable(function)(lambda context: typer)
    return lower_builtin(function, types.VarArg(types.Any))


def _vector_of(builder, kind, numbers):
    vector = ir.Constant(kind.vector, ir.Undefined)
    for k, number in enumerate(numbers):
        vector = builder.insert_element(vector, number, _INDEX(k))
    return vector


@instruction(simd.lanes, lambda numbers: LanesType(len(numbers)))
def _lanes(context, builder, signature, arguments):
    kind = signature.return_type
    numbers = (builder.extract_value(arguments[0], k) for k in range(kind.count))
    return _vector_of(builder, kind, numbers)


@instruction(simd.doubles_of, lambda a: types.UniTuple(types.float64, a.count))
def _doubles(context, builder, signature, arguments):
    count = range(signature.return_type.count)
    doubles = [builder.extract_element(arguments[0], _INDEX(k)) for k in count]
    return context.make_tuple(builder, signature.return_type, doubles)


@instruction(simd.bits_set_in_bytes, lambda word: LanesType(8)(types.uint64))
def _bits(context, builder, signature, arguments):
    kind = signature.return_type
    parts = builder.bitcast(arguments[0], ir.VectorType(ir.IntType(8), kind.count))
    counted = builder.call(function_named(builder, "llvm.ctpop.v8i8", parts.type, 1), [parts])
    return builder.uitofp(counted, kind.vector)


@instruction(simd.every, lambda number, like: like(types.float64, like))
def _every_lane(context, builder, signature, arguments):
    return _spread(builder, signature.return_type, arguments[0])


def _register_bound(function, relation):
    @instruction(function, lambda a, bound: a)
    def bounded(context, builder, signature, arguments):
        arguments = [_spread(builder, signature.return_type, operand) for operand in arguments]
        return builder.select(builder.fcmp_ordered(relation, *arguments), *arguments)


_register_bound(simd.at_least, ">")
_register_bound(simd.at_most, "<")


@instruction(simd.chosen, lambda by, a, b: a)
def _chosen(context, builder, signature, arguments):
    return builder.select(_above_zero(builder, arguments[0]), *arguments[1:])


@instruction(simd.root, lambda a: a)
def _root(context, builder, signature, arguments):
    kind, name, vector = signature.return_type, "llvm.sqrt.f64", _DOUBLE
    if isinstance(kind, LanesType):
        name, vector = f"llvm.sqrt.v{kind.count}f64", kind.vector
    return builder.call(function_named(builder, name, vector, 1), arguments)


@instruction(simd.packed, lambda a, by: a)
def _packed(context, builder, signature, arguments):
    kind, mask = signature.return_type.vector, _above_zero(builder, arguments[1])
    if llvm_version_info[0] < _COMPRESSES:
        return _packed_one_by_one(builder, arguments[0], mask)
    # As whole numbers: for processors without the instruction, LLVM 22 ends the process on constant
    # doubles in place of those not kept ("Cannot create FP integer constant").
    words = ir.VectorType(_INTEGER, kind.count)
    shape = ir.FunctionType(words, [words, mask.type, words])
    name = f"llvm.experimental.vector.compress.v{kind.count}i64"
    function = builder.module.globals.get(name) or ir.Function(builder.module, shape, name)
    zeros = ir.Constant(words, [0] * kind.count)
    bits = builder.call(function, [builder.bitcast(arguments[0], words), mask, zeros])
    return builder.bitcast(bits, kind)


def _packed_one_by_one(builder, a, mask):
    """As the instruction: each lane is stored after those kept, or a zero in its place."""
    count, place = a.type.count, ir.Constant(_INDEX, 0)
    memory = cgutils.alloca_once(builder, a.type)
    zero = ir.Constant(_DOUBLE, 0.0)
    builder.store(constant(a.type, 0.0), memory)
    first = builder.bitcast(memory, _DOUBLE.as_pointer())
    for k in range(count):
        kept = builder.extract_element(mask, _INDEX(k))
        number = builder.select(kept, builder.extract_element(a, _INDEX(k)), zero)
        builder.store(number, builder.gep(first, [place]))
        place = builder.add(place, builder.zext(kept, _INDEX))
    return builder.load(memory)


@instruction(simd.summed_up, lambda a: types.float64)
@instruction(simd.summed_for_each, lambda a, like: like(a, like))
def _summed(context, builder, signature, arguments):
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


@instruction(
    simd.for_each,
    lambda numbers, like: LanesType(
        len(numbers) * (like.count if isinstance(like, LanesType) else 1)
    ),
)
def _for_each(context, builder, signature, arguments):
    kind = signature.return_type
    count = kind.count // len(signature.args[0])
    numbers = (builder.extract_value(arguments[0], k // count) for k in range(kind.count))
    return _vector_of(builder, kind, numbers)


@instruction(simd.largest_lane, lambda a: types.float64)
def _largest(context, builder, signature, arguments):
    (left,) = arguments
    half = signature.args[0].count // 2
    while half:
        pair = [builder.shuffle_vector(left, left, _picked(range(k, k + half))) for k in (0, half)]
        left = builder.select(builder.fcmp_ordered(">", *pair), *pair)
        half //= 2
    return builder.extract_element(left, _INDEX(0))


@instruction(simd.positive_bits, lambda a: types.int64)
def _positive(context, builder, signature, arguments):
    above = builder.bitcast(_above_zero(builder, arguments[0]), ir.IntType(signature.args[0].count))
    return builder.zext(above, _INTEGER)


def _above_zero(builder, x):
    return builder.fcmp_ordered(">", x, constant(x.type, 0.0))


def fused(builder: Any, kind: LanesType, arguments: Sequence[Any]) -> Any:
    """The instruction for a b + c with one rounding, of vectors and doubles."""
    arguments = [_spread(builder, kind, operand) for operand in arguments]
    if not is_instruction("llvm.fma", 3):
        return error_free.fma(builder, *arguments)
    function = function_named(builder, f"llvm.fma.v{kind.count}f64", kind.vector, 3)
    return builder.call(function, arguments)


def lanes_signature(*kinds: Any) -> Any:
    """The signature of an operator on vectors, or on vectors and doubles; else None.

    The result is as long as the longest vector.
    """
    vectors = [kind for kind in kinds if isinstance(kind, LanesType)]
    others = [kind for kind in kinds if not isinstance(kind, (LanesType, types.Float))]
    if others or not vectors:
        return None
    longest = max(vectors, key=lambda kind: kind.count)
    return longest(*(kind if isinstance(kind, LanesType) else types.float64 for kind in kinds))


def function_named(builder: Any, name: str, kind: Any, count: int) -> Any:
    """LLVM's function of that name, of `count` values of a type to one."""
    function = builder.module.globals.get(name)
    return function or ir.Function(builder.module, ir.FunctionType(kind, [kind] * count), name)


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

    @type_callable(symbol)
    def of_context(context):
        return lambda a, b: lanes_signature(a, b)

    def applied(context, builder, signature, arguments):
        kind = signature.return_type
        return getattr(builder, instruction)(*(_spread(builder, kind, a) for a in arguments))

    for pair in ((LanesType, LanesType), (LanesType, types.Float), (types.Float, LanesType)):
        lower_builtin(symbol, *pair)(applied)


_operator(operator.add, "fadd")
_operator(operator.sub, "fsub")
_operator(operator.mul, "fmul")
_operator(operator.truediv, "fdiv")


@type_callable(operator.neg)
def _negative_type(context):
    return lambda a: a if isinstance(a, LanesType) else None


@lower_builtin(operator.neg, LanesType)
def _negative(context, builder, signature, arguments):
    return builder.fneg(arguments[0])


# ---- The instructions of `simd` that read and write arrays


def _register_read(function, count):
    @instruction(function, lambda array, i: LanesType(count) if array.is_contig else None)
    def read(context, builder, signature, arguments):
        vector = signature.return_type.vector
        place = _place(context, builder, signature.args[0], *arguments, vector)
        return builder.load(place, align=8)


def _place(context, builder, kind, array, i, vector):
    """A pointer to the vector that starts at array[i]."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [i]), vector.as_pointer())


_register_read(simd.four, 4)
_register_read(simd.eight, 8)
_register_read(simd.sixteen, 16)


def _put_type(array, i, *vectors):
    return types.void(array, types.intp, *vectors) if array.is_contig else None


@instruction(simd.put_eight, _put_type)
def _put_eight(context, builder, signature, arguments):
    array, i, numbers = arguments
    place = _place(context, builder, signature.args[0], array, i, numbers.type)
    builder.store(numbers, place, align=8)
    return context.get_dummy_value()


@instruction(simd.add_in_columns, _put_type)
def _add_in_columns(context, builder, signature, arguments):
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    count = signature.args[2].count
    numbers = [builder.fptosi(operand, ir.VectorType(_INDEX, count)) for operand in arguments[2:]]
    for k in range(count):
        row, amount = (builder.extract_element(vector, _INDEX(k)) for vector in numbers)
        row = builder.zext(builder.mul(row, _INDEX(count)), _INTEGER)
        pointer = builder.gep(data, [builder.add(arguments[1], row)])
        pointer = builder.gep(pointer, [_INDEX(k)])
        amount = builder.trunc(amount, ir.IntType(8))
        builder.store(builder.add(builder.load(pointer), amount), pointer)
    return context.get_dummy_value()


# ---- The instructions of `simd` on exponents and whole numbers

# Adding this leaves a whole number below 2^51 in the low bits.
_WHOLE = 3.0 * 2.0**51
# Adding this leaves a number of eighths below 2^48 there.
_EIGHTHS = 3.0 * 2.0**48


@instruction(simd.truncated, lambda a: a)
def _truncated(context, builder, signature, arguments):
    kind = signature.return_type
    whole = builder.fptosi(arguments[0], ir.VectorType(_INDEX, kind.count))
    return builder.sitofp(whole, kind.vector)


@instruction(simd.nearest_eighth, lambda a: a)
def _nearest_eighth(context, builder, signature, arguments):
    kind = signature.return_type
    total = _in_low_bits(builder, kind, arguments[0], _EIGHTHS)
    return _fenced(builder, kind, builder.fsub(total, constant(kind.vector, _EIGHTHS)))


@instruction(simd.inverse_power, lambda a: a)
def _inverse_power(context, builder, signature, arguments):
    kind = signature.return_type
    integers = like(kind.vector, _INTEGER)
    low = builder.bitcast(_in_low_bits(builder, kind, arguments[0], _EIGHTHS), integers)
    place = builder.and_(low, constant(integers, 7))
    table = ir.Constant(ir.VectorType(_DOUBLE, 8), [2.0 ** (-k / 8.0) for k in range(8)])
    # LLVM makes one permutation of eight such lanes where the processor has it.
    places = (builder.extract_element(place, _INDEX(k)) for k in range(kind.count))
    power = _vector_of(builder, kind, (builder.extract_element(table, k) for k in places))
    whole = builder.shl(builder.sub(low, place), constant(integers, 49))
    return builder.bitcast(builder.sub(builder.bitcast(power, integers), whole), kind.vector)


@instruction(simd.halved, lambda a, times: a)
def _halved(context, builder, signature, arguments):
    kind = signature.return_type
    integers = like(kind.vector, _INTEGER)
    times = builder.bitcast(_in_low_bits(builder, kind, arguments[1], _WHOLE), integers)
    shifted = builder.shl(times, constant(integers, 52))
    bits = builder.sub(builder.bitcast(arguments[0], integers), shifted)
    return builder.bitcast(bits, kind.vector)


@instruction(simd.exponent, lambda a: a)
def _exponent(context, builder, signature, arguments):
    kind = signature.return_type
    integers = like(kind.vector, _INTEGER)
    # the bits of 3/4, by which the exponents of 3/4 to 3/2 become zero
    first = constant(integers, 0x3FE8 << 48)
    above = builder.sub(builder.bitcast(arguments[0], integers), first)
    shifted = builder.ashr(above, constant(integers, 52))
    return builder.sitofp(shifted, kind.vector)


def _in_low_bits(builder, kind, a, number):
    """The sum with a number that rounds to a multiple of a power of two in the low bits."""
    return _fenced(builder, kind, builder.fadd(a, constant(kind.vector, number)))


def _fenced(builder, kind, a):
    """The vector, across which the compiler does not reorder sums."""
    name = f"llvm.arithmetic.fence.v{kind.count}f64"
    return builder.call(function_named(builder, name, kind.vector, 1), [a])


# ---- Stores past the caches

_LINE = ir.VectorType(_DOUBLE, simd.LINE)


@instruction(simd.past_line, lambda array: types.intp(array) if array.is_contig else None)
def _past_line(context, builder, signature, arguments):
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    number = builder.udiv(builder.ptrtoint(data, _INTEGER), _INTEGER(8))
    return builder.urem(number, _INTEGER(simd.LINE))


def _copy_line_type(source, i, target, j):
    if not (source.is_contig and target.is_contig):
        return None
    return types.void(source, types.intp, target, types.intp)


@instruction(simd.copy_line, _copy_line_type)
def _copy_line(context, builder, signature, arguments):
    source, target = (
        _place(context, builder, signature.args[k], *arguments[k : k + 2], _LINE) for k in (0, 2)
    )
    _store_line(builder, builder.load(source, align=8), target)
    return context.get_dummy_value()


def _store_line(builder, line, target):
    stored = builder.store(line, target, align=8 * simd.LINE)
    stored.set_metadata("nontemporal", builder.module.add_metadata([_INDEX(1)]))


@instruction(simd.put_line, _put_type)
def _put_line(context, builder, signature, arguments):
    array, i, line = arguments
    _store_line(builder, line, _place(context, builder, signature.args[0], array, i, _LINE))
    return context.get_dummy_value()


@instruction(simd.finish_stores, lambda: types.void())
def _finish_stores(context, builder, signature, arguments):
    builder.fence("seq_cst")
    return context.get_dummy_value()
