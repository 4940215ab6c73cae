"""Attitudes and rates of bodies from pole and angles of labelled axes, as papers give them.

The labels L and S of the axes, and the order of the turns, are those of
`attitude.published.conventions`.
"""

import math

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.solution.vectors import quaternion_of

# Branches of theta.
UNKNOWN, ACUTE, OBTUSE = 0, 1, 2
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
        places     (N, >= 2) y and 1 - y of `place_of_d`
        momenta    (N,) magnitude of the angular momentum, unit of the moments times rad/s
        angles     (N, 5) whose last column is psi, rad
    Filled
        angles[:, 3]  theta, rad
        rates         (N, 3) rad/s
        Both are NaN where psi does not come so far, or librates on an unknown branch.
    """
    for n in range(len(rates)):
        a, b, c = moments[n, 0], moments[n, 1], moments[n, 2]
        y, rest = places[n, 0], places[n, 1]
        if long_axis[n]:
            bd = (b - a) * y
            da, cd = (b - a) * rest, (c - b) + bd
        else:
            bd = -(c - b) * y
            da, cd = (b - a) - bd, (c - b) * rest
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
    total, rest = 0.5 * (angles[2] + angles[4]), 0.5 * (angles[2] - angles[4])
    u, v = math.cos(half), math.sin(half)
    euler = (u * math.cos(total), v * math.cos(rest), v * math.sin(rest), u * math.sin(total))
    found = _times(_times(pole, euler), (row[0], -row[1], -row[2], -row[3]))
    row[0], row[1], row[2], row[3] = found


@subroutine
def _times(p, q):
    """The product of two quaternions."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )
