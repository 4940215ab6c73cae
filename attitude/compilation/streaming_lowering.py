"""The instructions of `streaming` for numba; imported when the first function is compiled."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import lower_builtin, type_callable

from attitude.compilation import streaming

_INTEGER, _LINE = ir.IntType(64), ir.VectorType(ir.DoubleType(), streaming.LINE)


@type_callable(streaming.past_line)
def _past_line_type(context):
    return lambda array: types.intp(array) if array.is_contig else None


@lower_builtin(streaming.past_line, types.VarArg(types.Any))
def _past_line(context, builder, signature, arguments):
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    number = builder.udiv(builder.ptrtoint(data, _INTEGER), _INTEGER(8))
    return builder.urem(number, _INTEGER(streaming.LINE))


@type_callable(streaming.copy_line)
def _copy_line_type(context):
    def typer(source, i, target, j):
        if not (source.is_contig and target.is_contig):
            return None
        return types.void(source, types.intp, target, types.intp)

    return typer


@lower_builtin(streaming.copy_line, types.VarArg(types.Any))
def _copy_line(context, builder, signature, arguments):
    places = []
    for k in (0, 2):
        data = context.make_array(signature.args[k])(context, builder, arguments[k]).data
        place = builder.gep(data, [arguments[k + 1]])
        places.append(builder.bitcast(place, _LINE.as_pointer()))
    source, target = places
    _store_line(builder, builder.load(source, align=8), target)
    return context.get_dummy_value()


def _store_line(builder, line, target):
    stored = builder.store(line, target, align=8 * streaming.LINE)
    stored.set_metadata("nontemporal", builder.module.add_metadata([ir.IntType(32)(1)]))


@type_callable(streaming.put_line)
def _put_line_type(context):
    return lambda array, i, a: types.void(array, types.intp, a) if array.is_contig else None


@lower_builtin(streaming.put_line, types.VarArg(types.Any))
def _put_line(context, builder, signature, arguments):
    array, i, line = arguments
    data = context.make_array(signature.args[0])(context, builder, array).data
    place = builder.bitcast(builder.gep(data, [i]), _LINE.as_pointer())
    _store_line(builder, line, place)
    return context.get_dummy_value()


@type_callable(streaming.finish_stores)
def _finish_stores_type(context):
    return lambda: types.void()


@lower_builtin(streaming.finish_stores)
def _finish_stores(context, builder, signature, arguments):
    builder.fence("seq_cst")
    return context.get_dummy_value()
