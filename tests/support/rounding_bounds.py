"""How far all roundings of a traced program can turn what it returns, over many boxes at once.

Lemma (mean value theorem in the roundings).  Let node i be op(arguments) + e, |e| <= h_i, half a
unit in the last place of the largest |node i| in a box.  On the way from no roundings to all of
them each node stays in its interval widened by the roundings, so the direction of the result turns
by at most the sum of h_i times the supremum of the tangential derivative by node i over these
intervals: there is no remainder of second order.
"""

import numpy as np

from attitude.proof._intervals import UNIT_ROUNDOFF, Intervals, Turn, of

# Relative error of exp2_of_minus, where a trace has it as one operation; set by the caller.
LN2 = 0.6931471805599453
_EXACT = ("neg", "abs", "rint")


def half_ulp(x):
    """Half a unit in the last place of magnitudes."""
    return np.spacing(np.maximum(x, 1e-280)) / 2.0


def forward(nodes, inputs, exp2_error=0.0, omitted=()):
    """Intervals of all nodes with their roundings, and the largest rounding of each.

    `omitted` are nodes whose rounding is left out: a fault, which must make a bound smaller.
    """
    values, errors = [], []

    def value(argument):
        return of(argument[1]) if isinstance(argument, tuple) else values[argument]

    for place, (operation, arguments) in enumerate(nodes):
        x = [value(argument) for argument in arguments]
        error = None
        if operation.startswith("input:"):
            result, error = inputs[operation.partition(":")[2]], 0.0
        elif operation == "mul":
            same = arguments[0] == arguments[1]
            result = x[0].square() if same else x[0] * x[1]
            factors = [a[1] for a in arguments if isinstance(a, tuple)]
            if any(abs(factor) in (0.25, 0.5, 1.0, 2.0, 4.0) for factor in factors):
                error = 0.0
        elif operation == "exp2_of_minus":
            lo, hi = np.exp2(-x[0].hi), np.exp2(-x[0].lo)
            # exp2 of numpy is right to two units in the last place
            result = Intervals(lo * (1 - 4e-16), hi * (1 + 4e-16))
            error = exp2_error * result.hi
        else:
            result = _result(operation, x)
        if operation in _EXACT or place in omitted:
            error = 0.0
        if error is None:
            error = half_ulp(result.largest() * (1.0 + 4.0 * UNIT_ROUNDOFF))
        if np.any(error):
            result = Intervals.outward(result.lo - error, result.hi + error)
        values.append(result)
        errors.append(error)
    return values, errors


def _result(operation, x):
    if operation == "add":
        return x[0] + x[1]
    if operation == "sub":
        return x[0] - x[1]
    if operation == "fma":
        return x[0] * x[1] + x[2]
    if operation == "div":
        return x[0] / x[1]
    if operation == "sqrt":
        return x[0].sqrt()
    if operation == "neg":
        return -x[0]
    if operation == "abs":
        return x[0].absolute()
    raise ValueError(f"the analysis does not know {operation}")


def derivatives(nodes, values, output):
    """Intervals of the derivatives of one output by every node, by reverse mode."""
    slopes = [None] * len(nodes)
    slopes[output] = of(1.0)

    def value(argument):
        return of(argument[1]) if isinstance(argument, tuple) else values[argument]

    def put(argument, x):
        if not isinstance(argument, tuple):
            before = slopes[argument]
            slopes[argument] = x if before is None else before + x

    for place in range(output, -1, -1):
        slope = slopes[place]
        if slope is None:
            continue
        operation, arguments = nodes[place]
        if operation in ("add", "sub"):
            put(arguments[0], slope)
            put(arguments[1], slope if operation == "add" else -slope)
        elif operation in ("mul", "fma"):
            put(arguments[0], slope * value(arguments[1]))
            put(arguments[1], slope * value(arguments[0]))
            if operation == "fma":
                put(arguments[2], slope)
        elif operation == "div":
            put(arguments[0], slope / value(arguments[1]))
            put(arguments[1], -(slope * values[place] / value(arguments[1])))
        elif operation == "sqrt":
            put(arguments[0], slope * 0.5 / values[place])
        elif operation == "neg":
            put(arguments[0], -slope)
        elif operation == "abs":
            put(arguments[0], slope)  # of a positive argument
        elif operation == "exp2_of_minus":
            put(arguments[0], -(slope * values[place] * LN2))
    zero = of(0.0)
    return [zero if slope is None else slope for slope in slopes]


def turn(nodes, outputs, inputs, more=None, omitted=()):
    """The rotation angle, rad, by which all roundings can turn the four outputs, for each box.

    `more` adds errors of another origin, such as that of a polynomial: place -> magnitude.
    """
    values, errors = forward(nodes, inputs, omitted=omitted)
    slopes = [derivatives(nodes, values, output) for output in outputs]
    # two outputs, a sine and a cosine, are a direction in a plane
    missing = [of(0.0)] * (4 - len(outputs))
    total = Turn([*(values[output] for output in outputs), *missing])
    for place, error in enumerate(errors):
        size = error + (more or {}).get(place, 0.0)
        if np.any(size):
            total.add(size, [*(slope[place] for slope in slopes), *missing])
    return 2.0 * total.total()


def relative_error(nodes, output, inputs, more=0.0):
    """The largest relative error of one positive output, over all boxes."""
    values, errors = forward(nodes, inputs)
    slopes = derivatives(nodes, values, output)
    total = sum(
        error * slope.largest()
        for error, slope in zip(errors, slopes, strict=True)
        if np.any(error)
    )
    return float(np.max((total + more) / values[output].lo)) * (1.0 + 1e-10)
