"""Faster forms of four functions of numba, which make a quarter of the calls while it compiles.

The results are the same.  The names are private: each replacement is installed only where the
function of numba has the local variables for which it was written, and numba's own stays otherwise.

`BaseFunction.get_call_type`   finds the types of ``a + b`` by trying every registered addition, of
                               strings, sets and arrays too: kept for numbers, by their types
`Inst._rec_list_vars`          lists the variables of a statement, by tests against abstract classes
`TargetConfig.__eq__`, `__hash__`   compare 25 options, through a property each
"""

from __future__ import annotations

import operator
from typing import Any

from numba.core import ir, targetconfig, types
from numba.core.types import functions

# Operators whose types and machine code depend on nothing but the types of their arguments.
_OPERATORS = {
    *(operator.add, operator.sub, operator.mul, operator.truediv, operator.floordiv, operator.mod),
    *(operator.iadd, operator.isub, operator.imul, operator.itruediv, operator.neg, operator.pos),
    *(operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne),
    *(operator.and_, operator.or_, operator.xor, operator.lshift, operator.rshift, operator.not_),
}
_NUMBERS = (types.Number, types.Boolean, types.IntegerLiteral, types.BooleanLiteral)


def install() -> None:
    """Replace the functions that are as expected."""
    base, config = functions.BaseFunction, targetconfig.TargetConfig
    if _locals(base, "get_call_type")[:4] == ("self", "context", "args", "kws"):
        _set(base, "get_call_type", _call_types(base.get_call_type))
    if _locals(ir.Inst, "_rec_list_vars") == ("self", "val", "lst", "v"):
        _set(ir.Inst, "_rec_list_vars", _variables)
    if _locals(config, "__eq__") == ("self", "other") and config.__slots__ == ["_values"]:
        _set(config, "__eq__", _equal_or(config.__eq__))
        _set(config, "__hash__", _hashed)


def _set(kind: type, name: str, function: Any) -> None:
    setattr(kind, name, function)


def _locals(kind: Any, name: str) -> tuple[str, ...]:
    """Names of the local variables of a function of numba; none for one that was replaced."""
    function = getattr(kind, name, None)
    code = getattr(function, "__code__", None)
    return code.co_varnames if code and getattr(function, "__module__", "") != __name__ else ()


def _call_types(own: Any) -> Any:
    def get_call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws or self.typing_key not in _OPERATORS:
            return own(self, context, args, kws)
        if not all(isinstance(each, _NUMBERS) for each in args):
            return own(self, context, args, kws)
        # In the object itself: numba makes a new one where further additions are registered.
        known = self.__dict__.setdefault("_attitude_call_types", {})
        key = context, args
        found = known.get(key)
        if found is None:
            found = known[key] = own(self, context, args, kws)
        return found

    return get_call_type


def _variables(self: Any, value: Any) -> list[Any]:
    kind = type(value)
    if kind in _WITHOUT:
        return []
    if kind is ir.Var:
        return [value]
    if isinstance(value, ir.Inst):
        found: list[Any] = value.list_vars()
        return found
    inner = value.values() if kind is dict else value if kind in (list, tuple) else ()
    return [each for one in inner if type(one) not in _WITHOUT for each in _variables(self, one)]


# Types of the fields of statements that hold no variable.
_WITHOUT = {str, int, float, bool, type(None), ir.Loc}


def _equal_or(own: Any) -> Any:
    def equal(self: Any, other: Any) -> Any:
        if type(self) is type(other) and self._values == other._values:
            return True
        return own(self, other)

    return equal


def _hashed(self: Any) -> int:
    # As numba's own: of the names of the options, which a class has in common.
    return hash(type(self))
