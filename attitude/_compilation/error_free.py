"""Fused products and rounding for processors without these instructions, as LLVM code.

There LLVM calls the C library for ``llvm.fma`` and ``llvm.rint``: 0.1 us for each product, and no
loop with a call is vectorised.  The functions here take doubles, or vectors of doubles.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numba
from llvmlite import binding, ir

from attitude._compilation.instructions import FMA_RANGE

_DOUBLE = ir.DoubleType()
_INTEGER = ir.IntType(64)


@cache
def is_instruction(name: str, count: int) -> bool:
    """Whether LLVM makes an instruction, and no call, of an intrinsic of `count` doubles for the
    processor that numba compiles for, which NUMBA_CPU_NAME and NUMBA_CPU_FEATURES change.
    """
    module = ir.Module()
    function = ir.Function(module, ir.FunctionType(_DOUBLE, [_DOUBLE] * count), "probe")
    builder = ir.IRBuilder(function.append_basic_block())
    intrinsic = module.declare_intrinsic(name, [_DOUBLE], function.function_type)
    builder.ret(builder.call(intrinsic, function.args))
    config: Any = numba.config  # its names are made at import
    features = config.CPU_FEATURES
    if features is None:
        features = binding.get_host_cpu_features().flatten()
    machine = binding.Target.from_default_triple().create_target_machine(
        cpu=config.CPU_NAME or binding.get_host_cpu_name(), features=features, opt=2
    )
    called = name.removeprefix("llvm.")
    assembly = machine.emit_assembly(binding.parse_assembly(str(module)))
    return re.search(rf"\b_?{called}\b", assembly) is None


def fma(builder: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c, rounded once but for one case in 1e15 (see `instructions.loop_fma`)."""
    product, error = _two_product(builder, a, b)
    total = builder.fadd(product, c)
    addend = builder.fsub(total, product)
    over = builder.fadd(builder.fsub(builder.fsub(total, addend), product), builder.fsub(addend, c))
    # subtracted: adding a remainder of +0 would change the sign of a total of -0
    return builder.fsub(total, builder.fsub(over, error))


def descending_fma(builder: Any, a: Any, b: Any, c: Any) -> Any:
    """As `fma`, for |c| >= |a b|."""
    product, error = _two_product(builder, a, b)
    total = builder.fadd(c, product)
    over = builder.fsub(builder.fsub(total, c), product)
    return builder.fsub(total, builder.fsub(over, error))


def fma_of_any(builder: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c with one rounding, of any doubles: a call of a function of the module.

    Within `instructions.FMA_RANGE` by the algorithm of `instructions.fma` in Python (Boldo &
    Melquiond 2008), elsewhere by the C library.
    """
    name = "attitude.fma"
    function = builder.module.globals.get(name) or _fma_of_any(builder.module, name)
    return builder.call(function, [a, b, c])


def rint(builder: Any, x: Any) -> Any:
    """The nearest whole number, ties to even: adding 2^52 leaves no bits below 1."""
    first = ir.Constant(_DOUBLE, 2.0**52)  # larger numbers are whole
    size = _magnitude(builder, x)
    nearest = builder.fsub(builder.fadd(size, first), first)
    sign = builder.and_(builder.bitcast(x, _INTEGER), _INTEGER(-(1 << 63)))
    bits = builder.or_(builder.bitcast(nearest, _INTEGER), sign)
    small = builder.fcmp_ordered("<", size, first)
    return builder.select(small, builder.bitcast(bits, _DOUBLE), x)


def _two_product(builder, a, b):
    """The rounded product and its error, exact but for underflow (Dekker 1971).

    The upper 26 bits of `a` by a mask, those of `b` by rounding: the lower parts then have 27 and
    26 bits, and their products 53.
    """
    product = builder.fmul(a, b)
    integers = like(a.type, _INTEGER)
    masked = builder.and_(builder.bitcast(a, integers), constant(integers, -(1 << 27)))
    a_high = builder.bitcast(masked, a.type)
    a_low = builder.fsub(a, a_high)
    scaled = builder.fmul(b, constant(b.type, 134217729.0))  # 2^27 + 1
    b_high = builder.fsub(scaled, builder.fsub(scaled, b))
    b_low = builder.fsub(b, b_high)
    error = builder.fsub(builder.fmul(a_high, b_high), product)
    error = builder.fadd(error, builder.fmul(a_high, b_low))
    error = builder.fadd(error, builder.fmul(a_low, b_high))
    return product, builder.fadd(error, builder.fmul(a_low, b_low))


def _two_sum(builder, a, b):
    """The rounded sum and its error (Knuth)."""
    total = builder.fadd(a, b)
    addend = builder.fsub(total, a)
    a_error = builder.fsub(a, builder.fsub(total, addend))
    return total, builder.fadd(a_error, builder.fsub(b, addend))


def _fma_of_any(module, name):
    function = ir.Function(module, ir.FunctionType(_DOUBLE, [_DOUBLE] * 3), name)
    function.linkage = "internal"
    builder = ir.IRBuilder(function.append_basic_block())
    a, b, c = function.args
    product, error = _two_product(builder, a, b)
    with builder.if_then(_is_in_range(builder, (a, b, c, product)), likely=True):
        t, t_low = _two_sum(builder, c, error)
        v, v_low = _two_sum(builder, product, t)
        z = _rounded_to_odd(builder, t_low, v_low)
        builder.ret(builder.fadd(v, z))
    intrinsic = module.declare_intrinsic("llvm.fma", [_DOUBLE], function.function_type)
    builder.ret(builder.call(intrinsic, function.args))
    return function


def _is_in_range(builder, numbers):
    """Whether a, b, c and a b are within `FMA_RANGE`; a and b may be smaller, c may be zero."""
    smallest, largest = (ir.Constant(_DOUBLE, bound) for bound in FMA_RANGE)
    sizes = [_magnitude(builder, number) for number in numbers]
    inside = builder.fcmp_ordered(">", sizes[3], smallest)
    zero = builder.fcmp_ordered("==", sizes[2], ir.Constant(_DOUBLE, 0.0))
    above = builder.fcmp_ordered(">", sizes[2], smallest)
    inside = builder.and_(inside, builder.or_(zero, above))
    for size in sizes:
        inside = builder.and_(inside, builder.fcmp_ordered("<", size, largest))
    return inside


def _rounded_to_odd(builder, a, b):
    """a + b; if it is inexact, the neighbour of the exact sum whose last bit is set."""
    total, left = _two_sum(builder, a, b)
    bits = builder.bitcast(total, _INTEGER)
    even = builder.icmp_signed("==", builder.and_(bits, _INTEGER(1)), _INTEGER(0))
    inexact = builder.fcmp_ordered("!=", left, ir.Constant(_DOUBLE, 0.0))
    # one bit towards the remainder: away from zero if it has the sign of the total
    signs = builder.xor(bits, builder.bitcast(left, _INTEGER))
    towards = builder.or_(builder.ashr(signs, _INTEGER(63)), _INTEGER(1))
    change = builder.select(builder.and_(even, inexact), towards, _INTEGER(0))
    return builder.bitcast(builder.add(bits, change), _DOUBLE)


def _magnitude(builder, x):
    kind = ir.FunctionType(_DOUBLE, [_DOUBLE])
    return builder.call(builder.module.declare_intrinsic("llvm.fabs", [_DOUBLE], kind), [x])


def like(kind: Any, element: Any) -> Any:
    """The type of the elements, in a vector as long as that of another type, if it is one."""
    return ir.VectorType(element, kind.count) if isinstance(kind, ir.VectorType) else element


def constant(kind: Any, value: float) -> Any:
    """A number, in each lane of a vector if the type is one."""
    return ir.Constant(kind, [value] * kind.count if isinstance(kind, ir.VectorType) else value)
