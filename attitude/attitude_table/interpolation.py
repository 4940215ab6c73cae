"""Attitudes and rates between the records of a table: Lagrange, Hermite or great circles.

Each component of the quaternions is interpolated by the polynomial through a window of neighbouring
records (Hermite: through their derivatives too), in Newton's form, and the result is normalised, as
in SPICE's CK types 5 and 6.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray, IntArray
    from attitude.attitude_table.table import AttitudeTable

METHODS: tuple[str, ...] = ("slerp", "lagrange", "hermite")
MOST_DEGREE: int = 31
# The default: four records with rates, or eight without.
USUAL_DEGREE: int = 7
_CHUNK = 8192


def settled(method: str | None, degree: int | None, count: int, has_rates: bool) -> tuple[str, int]:
    """The method and degree of a table of `count` records, from those requested.

    None is the default.  Hermite without rates becomes Lagrange; a degree is reduced to that of
    all the records, and an even one of Hermite by one; a single record is a fixed attitude
    ("slerp").

    Raises
    ------
    AttitudeError
        For an unknown method, and a degree that is not a whole number from 1 to `MOST_DEGREE`.
    """
    if method is None:
        method = "hermite" if has_rates else "lagrange"
    method = method.lower()
    method = "slerp" if method in ("linear", "sphericallinear", "spherical linear") else method
    if method not in METHODS:
        raise AttitudeError(
            f"the interpolation method is {method[:40]!r}; it must be one of {', '.join(METHODS)}."
        )
    degree = USUAL_DEGREE if degree is None else degree
    whole = isinstance(degree, (int, np.integer)) and not isinstance(degree, bool)
    if not whole or not 1 <= degree <= MOST_DEGREE:
        raise AttitudeError(
            f"the interpolation degree is {degree!r}; give a whole number from 1 to {MOST_DEGREE}."
        )
    degree = int(degree)
    if method == "hermite" and not has_rates:
        method = "lagrange"
    if method == "slerp" or count == 1:
        return "slerp", 1
    if method == "hermite":
        return method, max(1, min((degree + 1) // 2, count)) * 2 - 1
    return method, min(degree, count - 1)


def evaluate(
    table: AttitudeTable, row: IntArray, ahead: FloatArray, *, order: int
) -> list[FloatArray]:
    """Attitudes of unit length and their derivatives.

    Parameters
    ----------
    table : AttitudeTable
        Of one segment.
    row : (T,) int array
        The record before each epoch, or at it.
    ahead : (T,) array
        Seconds from that record to the epoch.
    order : int
        0 for attitudes, 1 for angular velocities too, 2 for angular accelerations too.

    Returns
    -------
    list of arrays (T, 4), (T, 3), (T, 3), the first order + 1 of them
        Quaternions; rad/s and rad/s2 over the body axes.
    """
    parts = [
        _evaluate(table, row[k : k + _CHUNK], ahead[k : k + _CHUNK], order)
        for k in range(0, max(len(row), 1), _CHUNK)
    ]
    return [np.concatenate(each) for each in zip(*parts, strict=True)]


def _evaluate(table, row, ahead, order):
    found = _along_circles if table.method == "slerp" else _by_polynomial
    out = found(table, row, ahead, order)
    if order and table.angular_velocity is not None and table.method != "hermite":
        out[1:] = _interpolated_rates(table, row, ahead)[:order]
    return out


def _by_polynomial(table, row, ahead, order):
    repeat = 2 if table.method == "hermite" else 1
    width = (table.degree + 1) // repeat
    first, x, scale, at = _window(table, row, ahead, width)
    index = first[:, None] + np.arange(width)
    columns = [table.nodes[index[:, k]] for k in range(width)]
    slopes = None
    if repeat == 2:
        rates = [table.angular_velocity[index[:, k]] for k in range(width)]
        slopes = [
            scale[:, None] * forms.quaternion_rate(q, w)
            for q, w in zip(columns, rates, strict=True)
        ]
    p, dp, ddp = _newton(at, columns, slopes, x, order)
    square = np.sum(p * p, axis=1, keepdims=True)
    out = [p / np.sqrt(square)]
    if order:
        turn = quaternion.conjugate(p)
        omega = 2.0 * quaternion.multiply(turn, dp)[:, 1:] / square
        out.append(omega / scale[:, None])
    if order > 1:
        # d/dt of 2 vec(q* q') / |q|^2, in which vec(q'* q') vanishes
        change = 2.0 * np.sum(p * dp, axis=1, keepdims=True)
        bend = (2.0 * quaternion.multiply(turn, ddp)[:, 1:] - omega * change) / square
        out.append(bend / scale[:, None] ** 2)
    return out


def _window(table, row, ahead, width):
    """First record of each window, the epoch in it, its length in s, the epochs of its records.

    Epochs are in units of that length, from the record before the epoch.
    """
    first = np.clip(row - (width - 1) // 2, 0, len(table.seconds) - width)
    index = first[:, None] + np.arange(width)
    offsets = (table.seconds[index] - table.seconds[row][:, None]) + (
        table.low[index] - table.low[row][:, None]
    )
    scale = offsets[:, -1] - offsets[:, 0] if width > 1 else np.ones(len(row))
    return first, ahead / scale, scale, offsets / scale[:, None]


def polynomial(
    at: FloatArray,
    values: Sequence[FloatArray],
    slopes: Sequence[FloatArray] | None,
    x: FloatArray,
) -> FloatArray:
    """The polynomials (T, ...) through rows of values and slopes, at x.

    Parameters
    ----------
    at : (T, width) array
        Arguments of the values.
    values, slopes : lists of `width` arrays (T, ...)
        Values and derivatives there; slopes may be None.
    x : (T,) array
        Argument of each polynomial.
    """
    found: FloatArray = _newton(at, values, slopes, x, 0)[0]
    return found


def with_slope(
    at: FloatArray,
    values: Sequence[FloatArray],
    slopes: Sequence[FloatArray] | None,
    x: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """The polynomials of `polynomial` at x, and their derivatives, both (T, ...)."""
    found = _newton(at, values, slopes, x, 1)
    return found[0], found[1]


def _newton(at, values, slopes, x, order):
    """The polynomial through values (and slopes) at the columns of `at`, and two derivatives."""
    repeat = 1 if slopes is None else 2
    node = np.repeat(at, repeat, axis=1)
    level = [value for value in values for _ in range(repeat)]
    coefficients = [level[0]]
    for step in range(1, len(level)):
        following = []
        for k in range(len(level) - 1):
            if step == 1 and repeat == 2 and k % 2 == 0:
                following.append(slopes[k // 2])
            else:
                gap = (node[:, k + step] - node[:, k])[:, None]
                following.append((level[k + 1] - level[k]) / gap)
        level = following
        coefficients.append(level[0])
    p, dp, ddp = coefficients[-1], 0.0 * coefficients[-1], 0.0 * coefficients[-1]
    for k in range(len(coefficients) - 2, -1, -1):
        step = (x - node[:, k])[:, None]
        if order > 1:
            ddp = ddp * step + 2.0 * dp
        if order:
            dp = dp * step + p
        p = p * step + coefficients[k]
    return p, dp, ddp


def _along_circles(table, row, ahead, order):
    """The great circles from record to record, at a constant rate."""
    if len(table.seconds) == 1:
        return [table.nodes[row], np.zeros((len(row), 3)), np.zeros((len(row), 3))][: order + 1]
    start = np.minimum(row, len(table.seconds) - 2)
    step = (table.seconds[start + 1] - table.seconds[start]) + (
        table.low[start + 1] - table.low[start]
    )
    since = ahead + (
        (table.seconds[row] - table.seconds[start]) + (table.low[row] - table.low[start])
    )
    p, q = table.nodes[start], table.nodes[start + 1]
    turn = forms.to_rotation_vector(quaternion.multiply(quaternion.conjugate(p), q))
    part = forms.from_rotation_vector(turn * (since / step)[:, None])
    out = [quaternion.multiply(p, part), turn / step[:, None], np.zeros((len(row), 3))]
    return out[: order + 1]


def _interpolated_rates(table, row, ahead):
    """The rates of the records interpolated by the same method, componentwise; their derivative."""
    if len(table.seconds) == 1:
        return [table.angular_velocity[row], np.zeros((len(row), 3))]
    width = 2 if table.method == "slerp" else table.degree + 1
    first, x, scale, at = _window(table, row, ahead, width)
    values = [table.angular_velocity[first + k] for k in range(width)]
    p, dp, _ = _newton(at, values, None, x, 1)
    return [p, dp / scale[:, None]]
