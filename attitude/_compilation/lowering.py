"""The machine instructions of `instructions` and `pointers`; imported at the first compilation."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numba
from llvmlite import ir
from numba import carray, types
from numba.core import cgutils
from numba.core.caching import NullCache
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.extending import overload

from attitude._compilation import error_free, instructions, pointers, simd_lowering
from attitude._compilation.disk_cache import is_stamped, kept_on_disk
from attitude._compilation.error_free import is_instruction
from attitude._compilation.simd_lowering import function_named, instruction, lanes_signature
from attitude._compilation.wide_lowering import register_wide

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


register_wide()

_DOUBLE = ir.DoubleType()
_INTEGER = ir.IntType(64)
_F8 = types.float64
_I8 = types.int64
_POINTER = types.CPointer(_F8)
_C_FUNCTION = types.void(_F8, *[_POINTER] * 5)  # pointers.C_FUNCTION


def dispatcher(function: Callable[..., Any], options: Mapping[str, Any], kept: bool) -> Any:
    """numba's dispatcher of a function; with `kept` its machine code is kept on disk."""
    if kept:
        return _without_literals(kept_on_disk(function, options))
    is_inner = options.get("no_cpython_wrapper")
    compiler: dict[str, Any] = {"pipeline_class": _InnerCompiler} if is_inner else {}
    return _without_literals(numba.njit(**options, **compiler)(function))


class _InnerLibrary(JITCodeLibrary):
    """The code of a function that only compiled code calls: no machine code is made of it.

    Callers link its intermediate code and have their own machine code of it; numba would make that
    of the function alone too, for nothing.  The methods are private names of numba.
    """

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    @property
    def codegen(self) -> Any:
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Nothing: where no machine code is, no variable holds the environment."""


class _InnerCompiler(Compiler):
    """numba's compiler, which makes an `_InnerLibrary`."""

    def define_pipelines(self) -> Any:
        name = self.state.func_id.func_qualname
        self.state["library"] = _InnerLibrary(self.state.targetctx.codegen(), name)
        return super().define_pipelines()


def _without_literals(compiled: Any) -> Any:
    """The dispatcher, compiled for the type of an argument, not for its value.

    numba takes a whole number in the source for a type of its own and compiles a callee once more
    for each value, also for the first value of a variable of a loop: a fifth of all compilations.
    `Dispatcher.get_call_template` is private; without it, compiling takes longer.
    """
    resolve = getattr(compiled, "get_call_template", None)
    if resolve is None:
        return compiled

    def get_call_template(args: Any, kws: Any) -> Any:
        by_type = {name: types.unliteral(kind) for name, kind in dict(kws).items()}
        return resolve(tuple(map(types.unliteral, args)), by_type)

    compiled.get_call_template = get_call_template
    return compiled


def c_function(function: Callable[..., None], fastmath: bool | set[str], kept: bool) -> Any:
    """numba's C function of the type `pointers.C_FUNCTION`; with `kept`, on disk where possible."""
    options: dict[str, Any] = {"error_model": "numpy", "fastmath": fastmath}
    signature = (_C_FUNCTION.args, _C_FUNCTION.return_type)
    if kept:
        with suppress(RuntimeError):  # no folder for the cache
            compiled = _StampedCFunc(function, signature, {}, options)
            compiled.enable_caching()
            compiled.compile()
            return compiled
    return numba.cfunc(_C_FUNCTION, **options)(function)


class _StampedCFunc(CFunc):
    """A C function whose machine code on disk belongs to one state of all sources.

    What `numba.cfunc` makes, whose cache compares the file of the function alone.  The class, its
    `_cache`, `_pyfunc` and `NullCache` are private names of numba.
    """

    _cache: Any
    _pyfunc: Any

    def enable_caching(self) -> None:
        super().enable_caching()
        on_disk: Any = self._cache
        self._cache = on_disk if is_stamped(on_disk, self._pyfunc) else NullCache()


def _llvm(builder, name, arguments):
    """Call LLVM's intrinsic function of doubles with a name."""
    function = function_named(builder, f"{name}.f64", _DOUBLE, len(arguments))
    return builder.call(function, arguments)


def _register_fma(function, by_transforms):
    """The instruction of a b + c, or the functions of doubles that replace it."""

    @instruction(function, lambda a, b, c: lanes_signature(a, b, c) or _F8(_F8, _F8, _F8))
    def fma(context, builder, signature, arguments):
        if signature.return_type != _F8:
            return simd_lowering.fused(builder, signature.return_type, arguments)
        if is_instruction("llvm.fma", 3):
            return _llvm(builder, "llvm.fma", arguments)
        return by_transforms(builder, *arguments)


_register_fma(instructions.fma, error_free.fma_of_any)
_register_fma(instructions.loop_fma, error_free.fma)
_register_fma(instructions.descending_fma, error_free.descending_fma)


@instruction(instructions.rint, _F8(_F8))
def _rint(context, builder, signature, arguments):
    if is_instruction("llvm.rint", 1):
        return _llvm(builder, "llvm.rint", arguments)
    return error_free.rint(builder, *arguments)


@instruction(instructions.as_bits, _I8(_F8))
def _as_bits(context, builder, signature, arguments):
    return builder.bitcast(arguments[0], _INTEGER)


@instruction(instructions.from_bits, _F8(_I8))
def _from_bits(context, builder, signature, arguments):
    return builder.bitcast(arguments[0], _DOUBLE)


@instruction(instructions.chosen_if, _F8(types.boolean, _F8, _F8))
def _chosen_if(context, builder, signature, arguments):
    return builder.select(*arguments)


@instruction(instructions.larger, _F8(_F8, _F8))
def _larger(context, builder, signature, arguments):
    return builder.select(builder.fcmp_ordered(">", *arguments), *arguments)


@instruction(instructions.fence, _F8(_F8))
def _fence(context, builder, signature, arguments):
    return _llvm(builder, "llvm.arithmetic.fence", arguments)


@instruction(instructions.bits_set, types.uint8(types.uint8))
def _bits_set(context, builder, signature, arguments):
    return builder.ctpop(arguments[0])


@instruction(instructions.lowest_bit, types.uint64(types.uint64))
def _lowest_bit(context, builder, signature, arguments):
    return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))


@instruction(pointers.call, types.void(_I8, _F8, *[_I8] * 5))
def _call(context, builder, signature, arguments):
    pointer = _DOUBLE.as_pointer()
    kind = ir.FunctionType(ir.VoidType(), [_DOUBLE] + [pointer] * 5)
    function = builder.inttoptr(arguments[0], kind.as_pointer())
    addresses = [builder.inttoptr(integer, pointer) for integer in arguments[2:]]
    builder.call(function, [arguments[1], *addresses])
    return context.get_dummy_value()


@instruction(pointers.scratch, _I8())
def _scratch(context, builder, signature, arguments):
    memory = cgutils.alloca_once(builder, _DOUBLE, size=pointers.SCRATCH)
    return builder.ptrtoint(memory, _INTEGER)


@instruction(pointers.number, _F8(_I8, _I8))
def _number(context, builder, signature, arguments):
    return builder.load(_place(builder, _DOUBLE, *arguments))


@instruction(pointers.whole, _I8(_I8, _I8))
def _whole(context, builder, signature, arguments):
    return builder.load(_place(builder, _INTEGER, *arguments))


@instruction(pointers.put, types.void(_I8, _I8, _F8))
def _put(context, builder, signature, arguments):
    builder.store(arguments[2], _place(builder, _DOUBLE, *arguments[:2]))
    return context.get_dummy_value()


@instruction(pointers.put_three, types.void(_I8, _I8, _F8, _F8, _F8))
def _put_three(context, builder, signature, arguments):
    address, k, *numbers = arguments
    first = _place(builder, _DOUBLE, address, k)
    for offset, number in enumerate(numbers):
        builder.store(number, builder.gep(first, [_INTEGER(offset)]))
    return context.get_dummy_value()


def _place(builder, kind, address, k):
    """A pointer to the k-th number of a type at an address."""
    return builder.gep(builder.inttoptr(address, kind.as_pointer()), [k])


@overload(pointers.vector, inline="always")
def _vector(pointer, count):
    return lambda pointer, count: carray(pointer, (count,))
