"""The instructions of `simd` that read and write arrays; imported with `simd_lowering`."""

from __future__ import annotations

from llvmlite import ir
from numba import types

from attitude.compilation import simd
from attitude.compilation.simd_lowering import LanesType, lowered, typed

_INDEX = ir.IntType(32)


@typed(simd.eight)
def _eight_type(array, i):
    return LanesType(8) if array.is_contig else None


@typed(simd.four)
def _four_type(array, i):
    return LanesType(4) if array.is_contig else None


@typed(simd.sixteen)
def _sixteen_type(array, i):
    return LanesType(16) if array.is_contig else None


@lowered(simd.four)
@lowered(simd.sixteen)
@lowered(simd.eight)
def _eight(context, builder, signature, arguments):
    kind = signature.return_type
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    here = builder.gep(data, [arguments[1]])
    return builder.load(builder.bitcast(here, kind.vector.as_pointer()), align=8)


@typed(simd.put_eight)
def _put_eight_type(array, i, a):
    return types.void(array, types.intp, a) if array.is_contig else None


@lowered(simd.put_eight)
def _put_eight(context, builder, signature, arguments):
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    here = builder.gep(data, [arguments[1]])
    numbers = arguments[2]
    builder.store(numbers, builder.bitcast(here, numbers.type.as_pointer()), align=8)
    return context.get_dummy_value()


@typed(simd.add_in_columns)
def _add_type(array, i, rows, amounts):
    return types.void(array, types.intp, rows, amounts) if array.is_contig else None


@lowered(simd.add_in_columns)
def _add_in_columns(context, builder, signature, arguments):
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    count = signature.args[2].count
    numbers = [builder.fptosi(each, ir.VectorType(_INDEX, count)) for each in arguments[2:]]
    for k in range(count):
        row, amount = (builder.extract_element(each, _INDEX(k)) for each in numbers)
        row = builder.zext(builder.mul(row, _INDEX(count)), ir.IntType(64))
        here = builder.gep(data, [builder.add(arguments[1], row)])
        here = builder.gep(here, [_INDEX(k)])
        amount = builder.trunc(amount, ir.IntType(8))
        builder.store(builder.add(builder.load(here), amount), here)
    return context.get_dummy_value()
