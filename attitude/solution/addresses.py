"""Plain memory in compiled loops: numbers at addresses, and functions that are called by theirs.

Numba counts the users of an array by atomic instructions, for which all that is under way must be
waited for, wherever one is handed to a function; an address is a number like others.  Whoever takes
one sees to it that what lies there stays.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from attitude.solution.machine import inlined


@intrinsic
def call(typingctx, address, t, wxyz, omega, given, parameters, out):
    """Call a function of `solution.march`; all but t are addresses."""

    def codegen(context, builder, signature, arguments):
        double = ir.DoubleType()
        pointer = double.as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [double] + [pointer] * 5)
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        rest = [builder.inttoptr(each, pointer) for each in arguments[2:]]
        builder.call(function, [arguments[1], *rest])
        return context.get_dummy_value()

    i8, f8 = types.int64, types.float64
    return types.void(i8, f8, i8, i8, i8, i8, i8), codegen


@intrinsic
def room(typingctx):
    """The address of 16 doubles that last as long as the function that asks.

    An array would be given back after it is last named, whoever has its address.
    """

    def codegen(context, builder, signature, arguments):
        found = cgutils.alloca_once(builder, ir.DoubleType(), size=16)
        return builder.ptrtoint(found, ir.IntType(64))

    return types.int64(), codegen


@intrinsic
def number(typingctx, address, k):
    """The double in place k from an address."""

    def codegen(context, builder, signature, arguments):
        return builder.load(_place(builder, ir.DoubleType(), *arguments))

    return types.float64(types.int64, types.int64), codegen


@intrinsic
def whole(typingctx, address, k):
    """The whole number of 64 bits in place k from an address."""

    def codegen(context, builder, signature, arguments):
        return builder.load(_place(builder, ir.IntType(64), *arguments))

    return types.int64(types.int64, types.int64), codegen


@intrinsic
def put(typingctx, address, k, x):
    """A double into place k from an address."""

    def codegen(context, builder, signature, arguments):
        builder.store(arguments[2], _place(builder, ir.DoubleType(), *arguments[:2]))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.float64), codegen


def _place(builder, kind, address, k):
    return builder.gep(builder.inttoptr(address, kind.as_pointer()), [k])


@inlined
def put_three(address, k, x, y, z):
    put(address, k, x)
    put(address, k + 1, y)
    put(address, k + 2, z)
