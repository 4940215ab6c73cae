"""The operations of compiled functions, recorded from their own Python source.

`rebound` runs a function and all that it calls with other globals, so that numbers that remember
(`Node`) take the place of doubles; the modules themselves stay as they are.  Negation, changes of
sign, magnitudes and swaps are exact; every other operation rounds once.
"""

import types
from collections import Counter

from attitude._compilation.decorators import Compilable
from attitude._solver import series

_COMMUTE = ("add", "mul")
_NAMES = {"add": "sum", "sub": "sum"}


def _unchanged(operation, arguments):
    """The argument that an operation returns as it is, or None."""
    for x, y in ((0, 1), (1, 0)):
        if operation == "mul" and arguments[x] == ("constant", 1.0):
            return arguments[y]
    if operation == "sub" and arguments[1] == ("constant", 0.0):
        return arguments[0]
    return None


class Trace:
    """Operations in the order in which they were recorded.

    nodes: list of (operation, arguments); an argument is the number of a node, or ("constant", x).
    Inputs are the operation "input:NAME".
    counts_of_turns: places of the sums whose low bits are a count of turns.
    """

    def __init__(self):
        self.nodes, self.counts_of_turns = [], []

    def input(self, name):
        """A new input."""
        return Node(self, f"input:{name}")

    def inputs(self, *names):
        """New inputs, a tuple."""
        return tuple(self.input(name) for name in names)

    def counts(self, outputs, varying):
        """How often each operation is computed at every epoch, as a compiler leaves it.

        Operations on which no output depends, those of the inputs `varying` that no argument
        depends on, products with 1 and repeated operations are left out: the same bits.  Sums and
        differences are counted together, since a - b is a + (-b).
        """
        alias, seen, varies, counted = {}, {}, set(), []
        for place, (operation, arguments) in enumerate(self.nodes):
            arguments = tuple(a if isinstance(a, tuple) else alias[a] for a in arguments)
            unchanged = _unchanged(operation, arguments)
            is_plus_zero = operation == "add" and arguments[1] == ("constant", 0.0)
            if is_plus_zero and self.nodes[arguments[0]][0] == "sub":
                # a difference x - y of other numbers is never -0.0: adding 0.0 changes nothing
                unchanged = arguments[0]
            key = (
                operation,
                tuple(sorted(arguments, key=str)) if operation in _COMMUTE else arguments,
            )
            if unchanged is not None:
                alias[place] = unchanged
                continue
            alias[place] = seen.setdefault(key, place)
            if alias[place] != place:
                continue
            first = operation.removeprefix("input:") in varying or operation == "power_of_two"
            if first or any(a in varies for a in arguments):
                varies.add(place)
                counted.append((place, operation, arguments))
        needed = {alias[place] for place in (*outputs, *self.counts_of_turns)}
        result = Counter()
        for place, operation, arguments in reversed(counted):
            if place in needed:
                needed.update(a for a in arguments if not isinstance(a, tuple))
                result[_NAMES.get(operation, operation)] += 1
        return result


class Node:
    """A number that records what is done with it."""

    lanes = 1  # by which instructions.fma recognizes what has a `fused` of its own

    def __init__(self, trace, operation, *arguments):
        self.trace, self.place = trace, len(trace.nodes)
        known = (x.place if isinstance(x, Node) else ("constant", float(x)) for x in arguments)
        trace.nodes.append((operation, tuple(known)))

    def _new(self, operation, *arguments):
        return Node(self.trace, operation, *arguments)

    def __add__(self, other):
        return self._new("add", self, other)

    def __radd__(self, other):
        return self._new("add", other, self)

    def __sub__(self, other):
        return self._new("sub", self, other)

    def __rsub__(self, other):
        return self._new("sub", other, self)

    def __mul__(self, other):
        if isinstance(other, _Power):
            other = self._new("power_of_two")
        return self._new("mul", self, other)

    def __rmul__(self, other):
        return self._new("mul", other, self)

    def __truediv__(self, other):
        return self._new("div", self, other)

    def __rtruediv__(self, other):
        return self._new("div", other, self)

    def __neg__(self):
        return self._new("neg", self)

    def __abs__(self):
        return self._new("abs", self)

    def __gt__(self, other):
        # Comparisons of the loops are with 1e-300, which numbers exceed, and with 1000.
        return other < 1.0

    @staticmethod
    def fused(a, b, c):
        node = next(x for x in (a, b, c) if isinstance(x, Node))
        return node._new("fma", a, b, c)


class _Bits:
    """The bits of a number, of which only the sign is changed."""

    def __init__(self, number):
        self.number = number

    def __and__(self, mask):
        return self

    def __xor__(self, mask):
        return self


def replacements(quarter=0):
    """What takes the place of instructions that are no arithmetic, for a count of quarter turns.

    Signs of the arguments are those of the first octant: a change of sign rounds nothing.
    """

    def as_bits(x):
        if not isinstance(x, Node):
            return 0
        operation, arguments = x.trace.nodes[x.place]
        if operation == "add" and ("constant", _TO_LOW_BITS) in arguments:
            x.trace.counts_of_turns.append(x.place)
            return quarter
        return _Bits(x)

    return {
        "as_bits": as_bits,
        "from_bits": lambda bits: bits.number if isinstance(bits, _Bits) else _Power(),
        "rint": lambda x: x._new("rint", x),
        "math": types.SimpleNamespace(sqrt=lambda x: x._new("sqrt", x)),
    }


# Adding this leaves a whole number in the low bits of the sum.
_TO_LOW_BITS = series._TO_LOW_BITS


class _Power:
    """A power of two: a product with it is exact."""


def rebound(function, names, memo=None):
    """A Python function that runs as `function` does, with the globals in `names` replaced.

    Compiled functions that it calls, global or enclosed, are rebound too.
    """
    memo = {} if memo is None else memo
    python = function.py_func if isinstance(function, Compilable) else function
    if python not in memo:
        space, cells = {}, python.__closure__ or ()
        enclosed = [cell.cell_contents for cell in cells]
        enclosed = [
            rebound(value, names, memo) if isinstance(value, Compilable) else value
            for value in enclosed
        ]
        memo[python] = types.FunctionType(
            python.__code__,
            space,
            python.__name__,
            python.__defaults__,
            tuple(map(types.CellType, enclosed)),
        )
        for name, value in python.__globals__.items():
            if name in names:
                space[name] = names[name]
            elif name in python.__code__.co_names and isinstance(value, Compilable):
                space[name] = rebound(value, names, memo)
            else:
                space[name] = value
        space.setdefault("__builtins__", __builtins__)
    return memo[python]


def flat(values):
    """The nodes in nested tuples and lists, as places."""
    if isinstance(values, (tuple, list)):
        return [place for value in values for place in flat(value)]
    return [values.place]
