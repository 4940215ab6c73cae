"""Four or eight doubles as one value: vector arithmetic where the compiler would not find it.

A short loop is unrolled before it could be vectorised, and a formula at eight places is eight
formulas.  Here the eight are one number of the machine's vector type (eight: one AVX-512 register,
two of AVX2, four of NEON) that compiled code adds, multiplies and divides with the usual operators,
with doubles on either side; `machine.fma` takes them too.  Products and sums are fused where the
caller is compiled so (`attitude.scattering.machine`), and only there.
"""

import operator

from llvmlite import ir
from numba import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

_DOUBLE = ir.DoubleType()
_INDEX = ir.IntType(32)


class Lanes(types.Type):
    """Numba's type of some doubles; only compiled code has values of it."""

    def __init__(self, count):
        self.count = count
        super().__init__(f"lanes({count})")

    @property
    def vector(self):
        return ir.VectorType(_DOUBLE, self.count)


@register_model(Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, kind.vector)


@intrinsic
def eight(typingctx, array, i):
    """Eight neighbours array[i], ..., array[i + 7] of a contiguous array of doubles."""
    kind = Lanes(8)

    def codegen(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        here = builder.gep(data, [arguments[1]])
        return builder.load(builder.bitcast(here, kind.vector.as_pointer()), align=8)

    return kind(array, i), codegen


@intrinsic
def lanes(typingctx, numbers):
    """Doubles of a tuple, one to a lane."""
    kind = Lanes(len(numbers))

    def codegen(context, builder, signature, arguments):
        made = ir.Constant(kind.vector, ir.Undefined)
        for k in range(kind.count):
            one = builder.extract_value(arguments[0], k)
            made = builder.insert_element(made, one, _INDEX(k))
        return made

    return kind(numbers), codegen


@intrinsic
def bits_set_in_bytes(typingctx, word):
    """How many bits are set in each of the eight bytes of a word, the lowest first."""
    kind = Lanes(8)

    def codegen(context, builder, signature, arguments):
        parts = builder.bitcast(arguments[0], ir.VectorType(ir.IntType(8), kind.count))
        counted = builder.call(_function(builder, "llvm.ctpop.v8i8", parts.type, 1), [parts])
        return builder.uitofp(counted, kind.vector)

    return kind(types.uint64), codegen


@intrinsic
def at_least(typingctx, a, least):
    """The larger of two, lane by lane."""

    def codegen(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered(">", *arguments), *arguments)

    return a(a, a), codegen


@intrinsic
def root(typingctx, a):
    """The square root of each."""

    def codegen(context, builder, signature, arguments):
        function = _function(builder, f"llvm.sqrt.v{a.count}f64", a.vector, 1)
        return builder.call(function, arguments)

    return a(a), codegen


@intrinsic
def summed_up(typingctx, a):
    """The sum of all, in halves."""

    def codegen(context, builder, signature, arguments):
        (left,) = arguments
        half = a.count // 2
        while half:
            low = builder.shuffle_vector(left, left, _picked(range(half)))
            high = builder.shuffle_vector(left, left, _picked(range(half, 2 * half)))
            left = builder.fadd(low, high)
            half //= 2
        return builder.extract_element(left, _INDEX(0))

    return types.float64(a), codegen


def fused(builder, kind, arguments):
    """The instruction for a b + c with one rounding, of lanes and doubles."""
    arguments = [_spread(builder, kind, each) for each in arguments]
    function = _function(builder, f"llvm.fma.v{kind.count}f64", kind.vector, 3)
    return builder.call(function, arguments)


def lanes_among(kinds):
    """The type of the lanes among operands, the others being doubles; None if there are none."""
    found = {kind for kind in kinds if isinstance(kind, Lanes)}
    others = [kind for kind in kinds if not isinstance(kind, (Lanes, types.Float))]
    return found.pop() if len(found) == 1 and not others else None


def _function(builder, name, kind, count):
    found = builder.module.globals.get(name)
    return found or ir.Function(builder.module, ir.FunctionType(kind, [kind] * count), name)


def _spread(builder, kind, x):
    """A double in every lane; lanes as they are."""
    if x.type == kind.vector:
        return x
    none = ir.Constant(kind.vector, ir.Undefined)
    first = builder.insert_element(none, x, _INDEX(0))
    return builder.shuffle_vector(first, none, _picked([0] * kind.count))


def _picked(places):
    places = list(places)
    return ir.Constant(ir.VectorType(_INDEX, len(places)), places)


def _with_operator(symbol, instruction):
    @infer_global(symbol)
    class Typed(AbstractTemplate):
        def generic(self, args, kws):
            kind = lanes_among(args)
            if kind is None:
                return None
            return signature(kind, *(a if a == kind else types.float64 for a in args))

    def applied(context, builder, sig, args):
        kind = sig.return_type
        return getattr(builder, instruction)(*(_spread(builder, kind, a) for a in args))

    for pair in ((Lanes, Lanes), (Lanes, types.Float), (types.Float, Lanes)):
        lower_builtin(symbol, *pair)(applied)


_with_operator(operator.add, "fadd")
_with_operator(operator.sub, "fsub")
_with_operator(operator.mul, "fmul")
_with_operator(operator.truediv, "fdiv")
