"""Set-up of the sensitivity: one record of solution.tangent_record for each motion."""

import math

from attitude.compilation.decorators import slowly_compiled, subroutine
from attitude.solution import codes
from attitude.solution.columns import attitude_column, found_rows
from attitude.solution.derivatives import derive, passage
from attitude.solution.given_axes import product, turned_by, unit
from attitude.solution.series import four
from attitude.solution.tangent_record import (
    BLOCK,
    COLUMNS,
    FOUND,
    NOME,
    PASSED,
    PHASE,
    RATE,
    SECOND,
    THIRD,
    TIME,
)
from attitude.solution.tangent_series import fill_hyperbolic, fill_rates, fill_trigonometric
from attitude.solution.tangents import hyperbolic_block, trigonometric_block
from attitude.solution.uniform_tangents import fill_uniform, unit_vector


@slowly_compiled
def uniform_setup(moments, wxyz, principal, constants, tangents):
    """Fill the records of those of B motions that rotate uniformly; as `tumbling_setup`."""
    for b in range(len(constants)):
        c, d = constants[b], tangents[b]
        if c.fault == codes.FINE and c.form == codes.UNIFORM:
            to_body = four(principal[b if len(principal) > 1 else 0])
            of_moments = moments[b, 0, 0], moments[b, 1, 0], moments[b, 2, 0]
            _state(c, d, of_moments, four(wxyz[b]), to_body)
            fill_uniform(c, d, of_moments, four(wxyz[b]), to_body)


@slowly_compiled
def tumbling_setup(moments, wxyz, principal, constants, tangents, block):
    """Fill the records of those of B motions that tumble.

    Given
        moments    (B, 3, 2) principal moments, pairs, all above zero
        wxyz       (B, 4) body to inertial at the epoch, of any length
        principal  (1 or B, 4) principal axes to given body axes
        constants  (B,) of solution.record.CONSTANTS
        block      (ROWS BLOCK,) working memory
    Filled
        tangents   (B,) of solution.tangent_record.TANGENTS, zeros at first
    """
    for b in range(len(constants)):
        c, d = constants[b], tangents[b]
        if c.fault == codes.FINE and c.form != codes.UNIFORM:
            to_body = four(principal[b if len(principal) > 1 else 0])
            of_moments = moments[b, 0, 0], moments[b, 1, 0], moments[b, 2, 0]
            _state(c, d, of_moments, four(wxyz[b]), to_body)
            _passage(c, d)
            derive(math.frexp(max(of_moments[0], of_moments[1], of_moments[2]))[1], c, d.by_input)
            _invariant(c.frame, d.invariant)
            _weights(c, d)
            fill_rates(c, d)
            epoch = block[FOUND : FOUND + 1]
            epoch[0] = 0.0
            if c.form == codes.TRIGONOMETRIC:
                fill_trigonometric(c, d.series, d.upright)
                trigonometric_block(c, d, epoch, None, block)
            else:
                fill_hyperbolic(c, d, d.series, d.upright)
                hyperbolic_block(c, d, epoch, None, block)
                d.passed, block[PASSED] = block[PASSED], 0.0
            x, y, z = found_rows(block, 1)
            for j in range(COLUMNS):
                attitude_column(d, j, block, x, y, z)
                for k in range(3):
                    d.offset[k, j] = (1.0 if j == k else 0.0) - block[FOUND + k * BLOCK]


@subroutine
def _state(c, d, moments, wxyz, to_body):
    """Fill momentum, inverse inertia and principal axes."""
    start = unit(wxyz)
    omega = (
        math.ldexp(c.omega[0, 0], c.tempo),
        math.ldexp(c.omega[1, 0], c.tempo),
        math.ldexp(c.omega[2, 0], c.tempo),
    )
    to_inertial = product(start, to_body)
    found = turned_by(
        to_inertial, (moments[0] * omega[0], moments[1] * omega[1], moments[2] * omega[2])
    )
    for k in range(3):
        d.momentum[k] = found[k]
        d.inverse[k] = 1.0 / moments[k]
        _put(d.principal, k, turned_by(to_body, unit_vector(k)))


@subroutine
def _passage(c, d):
    """Fill decay and nome of the hyperbolic form."""
    if c.form == codes.HYPERBOLIC:
        (d.decay[0], d.decay[1]), d.nome = passage(c)


@subroutine
def _put(matrix, column, v):
    for k in range(3):
        matrix[k, column] = v[k]


@subroutine
def _invariant(frame, invariant):
    """Fill the axes of the solution: frame is q -> l q r, and l e l* = (l e r)(l r)*."""
    w, x, y, z = frame[0, 0], -frame[1, 0], -frame[2, 0], -frame[3, 0]
    for k in range(3):
        column = frame[0, k + 1], frame[1, k + 1], frame[2, k + 1], frame[3, k + 1]
        found = product(column, (w, x, y, z))
        for i in range(3):
            invariant[i, k] = found[1 + i]


@subroutine
def _weights(c, d):
    """Fill the weights of the six columns of angular velocity and moments, and `by_third`."""
    by_input, weights, largest = d.by_input, d.weights, 0.0
    for k in range(6):
        j = 3 + k
        weights[TIME, j] = by_input[0, k]
        weights[RATE, j] = by_input[1, k]
        weights[PHASE, j] = by_input[2, k]
        weights[NOME, j] = by_input[7, k]
        for row in range(3):
            d.amplitudes[row, j] = by_input[8 + row, k]
        if c.form == codes.TRIGONOMETRIC:
            weights[SECOND, j] = by_input[3, k]
            weights[THIRD, j] = by_input[4, k]
            continue
        weights[SECOND, j] = by_input[4, k]
        third = weights[THIRD, j] = by_input[5, k]
        winds = c.winds != 0.0  # on the exact separatrix nothing passes
        if abs(third) > largest:
            # ln K' and K pi/(2K') depend on Q' alone: the ratio is that of all columns
            largest = abs(third)
            d.by_third[0] = by_input[3, k] / third
            d.by_third[1] = by_input[6, k] / third if winds else 0.0
