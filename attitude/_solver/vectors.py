"""Vectors turned by attitudes, angles between vectors, and states from labelled axes, compiled.

All arrays are component-major, (4, N) for attitudes and (3, N) for vectors, so that LLVM vectorises
the loops; a vector (3, 1) is the same for all epochs.  `attitude.frames.quaternion.rotate` does
the same in numpy, at some 60 ns an epoch where `to_body` takes 3 to 5.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude._compilation.decorators import (
    force_inlined,
    named,
    quickly_compiled,
    sized_entry_point,
    subroutine,
)
from attitude._solver.kernel import product

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray


# Angles that are computed together: temporary arrays stay in the second-level cache.
_BLOCK = 1 << 14


@subroutine
def quaternion_of(r, wxyz):
    """Fill the quaternion, w >= 0, of a rotation matrix (3, 3).

    By Shepperd's method (J. Guidance and Control 1, 223, 1978), with the bits of scipy's Rotation.
    """
    trace = r[0, 0] + r[1, 1] + r[2, 2]
    i = 0
    if r[1, 1] > r[0, 0]:
        i = 1
    if r[2, 2] > r[i, i]:
        i = 2
    if trace > r[i, i]:
        w = 1.0 + trace
        x, y, z = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        w = r[k, j] - r[j, k]
        t, u, v = 1.0 - trace + 2.0 * r[i, i], r[j, i] + r[i, j], r[k, i] + r[i, k]
        x, y, z = (t, u, v) if i == 0 else ((v, t, u) if i == 1 else (u, v, t))
    size = math.sqrt(x * x + y * y + z * z + w * w)
    first = x if x != 0.0 else (y if y != 0.0 else z)
    if w < 0.0 or (w == 0.0 and first < 0.0):
        size = -size
    wxyz[0], wxyz[1], wxyz[2], wxyz[3] = w / size, x / size, y / size, z / size


@force_inlined
def _one(a, k):
    """The number of all epochs."""
    return a


@force_inlined
def _each(a, k):
    """The number of epoch k."""
    return a[k]


def to_body(wxyz: FloatArray, vectors: FloatArray, out: FloatArray) -> None:
    """Fill components over the body axes (3, N) of inertial vectors (3, 1 or N): out = q* v q."""
    # Two loops, of which a scene mostly compiles one.
    if vectors.shape[1] == 1:
        _one_to_body(wxyz, vectors[0, 0], vectors[1, 0], vectors[2, 0], out)
    else:
        _each_to_body(wxyz, vectors[0], vectors[1], vectors[2], out)


def _to_body_of(name, number):
    """The loop over attitudes (4, N), of one vector or of each."""

    def loop(wxyz, p, q, r, out):
        for k in range(wxyz.shape[1]):
            w, x, y, z = wxyz[0, k], wxyz[1, k], wxyz[2, k], wxyz[3, k]
            a, b, c = number(p, k), number(q, k), number(r, k)
            # v - 2 w (u x v) + 2 u x (u x v), u being the vector part of q
            d = 2.0 * (y * c - z * b)
            e = 2.0 * (z * a - x * c)
            f = 2.0 * (x * b - y * a)
            out[0, k] = a - w * d + (y * f - z * e)
            out[1, k] = b - w * e + (z * d - x * f)
            out[2, k] = c - w * f + (x * e - y * d)

    return quickly_compiled(named(loop, name))


_one_to_body = _to_body_of("_one_to_body", _one)
_each_to_body = _to_body_of("_each_to_body", _each)


def separation(
    ax: FloatArray,
    ay: FloatArray,
    az: FloatArray,
    bx: FloatArray,
    by: FloatArray,
    bz: FloatArray,
) -> FloatArray:
    """Angles (N,) in rad between unit vectors of components (N,) or (1,), as 2 atan2(|a - b|, |a +
    b|): an arc cosine loses half of its digits at 0 and pi.
    """
    if ax.size == 1:
        ax, ay, az, bx, by, bz = bx, by, bz, ax, ay, az
    angle, of_sum = np.empty(ax.size), np.empty(min(ax.size, _BLOCK))
    for begin in range(0, angle.size, _BLOCK):
        chord = angle[begin : begin + _BLOCK]
        block = slice(begin, begin + chord.size)
        first = ax[block], ay[block], az[block]
        if bx.size == 1:
            _from_one(*first, bx[0], by[0], bz[0], chord, of_sum)
        else:
            _from_each(*first, bx[block], by[block], bz[block], chord, of_sum)
        np.arctan2(chord, of_sum[: chord.size], out=chord)
        chord *= 2.0
    return angle


def _distances_from(name, number):
    """The loop that fills |a - b| and |a + b|, of one vector b or of each."""

    def loop(ax, ay, az, bx, by, bz, difference, total):
        for k in range(difference.size):
            p, q, r = number(bx, k), number(by, k), number(bz, k)
            x, y, z = ax[k] - p, ay[k] - q, az[k] - r
            difference[k] = math.sqrt(x * x + y * y + z * z)
            x, y, z = ax[k] + p, ay[k] + q, az[k] + r
            total[k] = math.sqrt(x * x + y * y + z * z)

    return quickly_compiled(named(loop, name))


_from_one = _distances_from("_from_one", _one)
_from_each = _distances_from("_from_each", _each)


# ---- Attitudes and rates of bodies from pole and angles of labelled axes, as papers give them
# The labels L and S of the axes, and the order of the turns, are those of
# `attitude.motions._conventions`.

# Branches of theta.
UNKNOWN = 0
ACUTE = 1
OBTUSE = 2
# Rounding of cos^2 theta at the ends of a libration of psi, relative to its terms.
_ROUNDING = 1e-14


@sized_entry_point
def rates_all(moments, long_axis, long_labels, branches, places, momenta, angles, rates):
    """Fill theta and the angular velocities over the labelled axes.

    Where psi circulates, sin^2 and cos^2 of theta are sums of terms of one sign.

    Given
        moments    (N, 3) ascending
        long_axis, long_labels   (N,) booleans: long-axis mode, else short-axis; labels L, else S
        branches   (N,) theta up to 90 degrees: ACUTE, above: OBTUSE, or UNKNOWN, which is ACUTE
                   where psi circulates
        places     (N, >= 2) y and 1 - y of `regimes`
        momenta    (N,) magnitude of the angular momentum, unit of the moments times rad/s
        angles     (N, 5) whose last column is psi, rad
    Filled
        angles[:, 3]  theta, rad
        rates         (N, 3) rad/s
        Both are NaN where psi does not come so far, or librates on an unknown branch.
    """
    for n in range(len(rates)):
        a, b, c = moments[n, 0], moments[n, 1], moments[n, 2]
        y, complement = places[n, 0], places[n, 1]
        if long_axis[n]:
            bd = (b - a) * y
            da, cd = (b - a) * complement, (c - b) + bd
        else:
            bd = -(c - b) * y
            da, cd = (b - a) - bd, (c - b) * complement
        sine, cosine = math.sin(angles[n, 4]), math.cos(angles[n, 4])
        s, k = sine * sine, cosine * cosine
        if long_labels[n]:
            across, p, q = da / a, s * bd / b, k * cd / c
            first, second, third = b, c, a
        else:
            across, p, q = cd / c, s * da / a, -k * bd / b
            first, second, third = a, b, c
        along = p + q
        theta = math.atan2(math.sqrt(across), math.sqrt(max(along, 0.0)))
        if along < -_ROUNDING * (across + abs(p) + abs(q)):
            theta = math.nan
        if branches[n] == OBTUSE:
            theta = math.pi - theta
        elif branches[n] != ACUTE and long_axis[n] != long_labels[n]:
            theta = math.nan
        angles[n, 3] = theta
        tilt = math.sin(theta)
        rates[n, 0] = tilt * sine * (momenta[n] / first)
        rates[n, 1] = tilt * cosine * (momenta[n] / second)
        rates[n, 2] = math.cos(theta) * (momenta[n] / third)


@sized_entry_point
def states_all(axes, order, long_labels, angles, rates, matrix, wxyz, omega):
    """Fill attitudes and angular velocities of bodies from those of their labelled axes.

    Given
        axes         (1 or N, 3, 3) principal axes as columns over the body axes
        order        (N, 3) indices of the principal moments, ascending
        long_labels  (N,) booleans: the labels L, else S
        angles       (N, 5) longitude and latitude of the pole, phi, theta, psi, rad
        rates        (N, 3) rad/s over the labelled axes
        matrix       (3, 3) memory for the labelled axes of one body
    Filled
        wxyz, omega  (N, 4), (N, 3): body axes to the frame of the pole; rad/s over the body axes
    """
    for n in range(len(wxyz)):
        principal = axes[n if len(axes) > 1 else 0]
        least, greatest = order[n, 0], order[n, 2]
        # the columns of the axes of A, B and C; B makes them right-handed
        a, b, c = (2, 0, 1) if long_labels[n] else (0, 1, 2)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            matrix[i, a], matrix[i, c] = principal[i, least], principal[i, greatest]
            matrix[i, b] = (
                principal[j, greatest] * principal[k, least]
                - principal[k, greatest] * principal[j, least]
            )
        for i in range(3):
            total = matrix[i, 0] * rates[n, 0] + matrix[i, 1] * rates[n, 1]
            omega[n, i] = total + matrix[i, 2] * rates[n, 2]
        row = wxyz[n]
        quaternion_of(matrix, row)
        _turned(angles[n], row)


@subroutine
def _turned(angles, row):
    """Replace q by Rz(longitude) Ry(90 deg - latitude) Rz(phi) Rx(theta) Rz(psi) q*."""
    east, south = 0.5 * angles[0], 0.5 * (0.5 * math.pi - angles[1])
    c, s, u, v = math.cos(east), math.sin(east), math.cos(south), math.sin(south)
    pole = (c * u, -s * v, c * v, s * u)
    half = 0.5 * angles[3]
    total, diff = 0.5 * (angles[2] + angles[4]), 0.5 * (angles[2] - angles[4])
    u, v = math.cos(half), math.sin(half)
    euler = (u * math.cos(total), v * math.cos(diff), v * math.sin(diff), u * math.sin(total))
    turned = product(product(pole, euler), (row[0], -row[1], -row[2], -row[3]))
    row[0], row[1], row[2], row[3] = turned
