"""Compiling takes no longer than necessary: one specialisation for a type, numba's slow parts."""

import operator

import numpy as np
import pytest
from numba.core import ir, targetconfig, types
from numba.core.registry import cpu_target
from numba.core.types import functions

from attitude.compilation import lowering, numba_speed
from attitude.compilation.decorators import entry_point, subroutine


@subroutine
def _scaled(x, times):
    return x * times


@entry_point
def _summed(x):
    total = _scaled(x, 2) + _scaled(x, 3) + _scaled(x, 5)
    for k in range(4):
        total += _scaled(x, k)
    return total


def test_a_callee_is_compiled_for_types_not_for_values():
    assert _summed.dispatcher(1.5) == 24.0
    (signature,) = _scaled.dispatcher.signatures
    assert signature == (types.float64, types.int64)


def test_the_replacements_are_installed_in_this_version_of_numba():
    assert lowering.numba_speed is numba_speed
    assert ir.Inst._rec_list_vars is numba_speed._variables
    assert targetconfig.TargetConfig.__eq__.__module__ == numba_speed.__name__
    assert functions.BaseFunction.get_call_type.__module__ == numba_speed.__name__


def test_other_functions_of_numba_stay(monkeypatch):
    def renamed(self, context, positional, named):
        return None

    monkeypatch.setattr(functions.BaseFunction, "get_call_type", renamed)
    monkeypatch.setattr(ir.Inst, "_rec_list_vars", lambda self, node: [])
    kept = ir.Inst._rec_list_vars
    numba_speed.install()
    assert functions.BaseFunction.get_call_type is renamed
    assert ir.Inst._rec_list_vars is kept


@pytest.mark.parametrize(
    ("one", "two", "result"),
    [
        (types.float64, types.int64, types.float64),
        (types.int64, types.int64, types.int64),
        (types.float64, types.literal(2), types.float64),
    ],
)
def test_types_of_operators_are_those_of_numba(one, two, result):
    context = cpu_target.typing_context
    context.refresh()
    for _ in range(2):
        found = context.resolve_function_type(operator.add, (one, two), {})
        assert found.return_type == result


def test_variables_of_a_statement():
    here = ir.Loc("file", 1)
    a, b, c = (ir.Var(None, name, here) for name in "abc")
    inner = ir.Expr.build_tuple([a, b], here)
    assert {each.name for each in ir.Assign(inner, c, here).list_vars()} == {"a", "b", "c"}
    call = ir.Expr.call(a, [b], (("key", c),), here)
    assert [each.name for each in call.list_vars()] == ["a", "b", "c"]


def test_options_compare_as_before():
    one, two = (targetconfig.TargetConfig() for _ in range(2))
    assert one == two and hash(one) == hash(two) and one != 3

    class Options(targetconfig.TargetConfig):
        fast = targetconfig.Option(type=bool, default=False, doc="")

    one, two = Options(), Options()
    two.fast = False  # the default, given
    assert one == two
    two.fast = True
    assert one != two and np.unique([hash(one), hash(two)]).size == 1
