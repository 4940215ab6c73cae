"""Columns of the sensitivity from the tangents of a block of epochs.

Given
    d          record of solution.tangent_record
    j          number of the column
    n          epochs of the block
    block      rows that solution.tangents filled
Filled
    block      FOUND: three rows, the rotation vector of the change of attitude over inertial axes,
               or the change of the angular velocity, rad/s over the given body axes
"""

from attitude.compilation.decorators import force_inlined
from attitude.compilation.instructions import fma
from attitude.solution.tangent_record import (
    BASIS,
    BLOCK,
    FOUND,
    OMEGA,
    PASSAGE,
    PASSED,
    PHASE,
    RATE,
    SECOND,
    SECONDS,
    SUMS,
    THIRD,
    TIME,
    TURN,
    TURNED,
    WIND,
    WXYZ,
    Y,
)


@force_inlined
def attitude_column(d, j, n, block):
    """Fill the change of attitude of a motion that tumbles."""
    w = d.weights
    time, rate, start = w[TIME, j], w[RATE, j], w[PHASE, j]
    second, third, turn = w[SECOND, j], w[THIRD, j], w[TURN, j]
    passage, wind = w[PASSAGE, j], w[WIND, j]
    lx, ly, lz = d.invariant[0, 2], d.invariant[1, 2], d.invariant[2, 2]
    ox, oy, oz = d.offset[0, j], d.offset[1, j], d.offset[2, j]
    for i in range(n):
        seconds, passed = block[SECONDS + i], block[PASSED + i]
        a = fma(-turn, block[Y + i], fma(-passage, passed, fma(rate, seconds, start)))
        along = fma(time, seconds, wind * passed)
        x = fma(block[BASIS + 6 * BLOCK + i], third, lx * along)
        y = fma(block[BASIS + 7 * BLOCK + i], third, ly * along)
        z = fma(block[BASIS + 8 * BLOCK + i], third, lz * along)
        x = fma(block[BASIS + i], a, fma(block[BASIS + 3 * BLOCK + i], second, x))
        y = fma(block[BASIS + BLOCK + i], a, fma(block[BASIS + 4 * BLOCK + i], second, y))
        z = fma(block[BASIS + 2 * BLOCK + i], a, fma(block[BASIS + 5 * BLOCK + i], second, z))
        block[FOUND + i] = x + ox
        block[FOUND + BLOCK + i] = y + oy
        block[FOUND + 2 * BLOCK + i] = z + oz


@force_inlined
def rate_column(d, j, n, block):
    """Fill the change of the angular velocity of a motion that tumbles.

    The body's momentum changes by R^T (dL - eta x L) = I dw + dI w; what turns about L alone is
    left out of eta, so that its growth with time costs no digits.
    """
    w = d.weights
    rate, start = w[RATE, j], w[PHASE, j]
    second, third, turn, passage = w[SECOND, j], w[THIRD, j], w[TURN, j], w[PASSAGE, j]
    lx, ly, lz = d.momentum[0], d.momentum[1], d.momentum[2]
    ox, oy, oz = d.offset[0, j], d.offset[1, j], d.offset[2, j]
    ix, iy, iz = d.impulse[0, j], d.impulse[1, j], d.impulse[2, j]
    p, inverse = d.principal, d.inverse
    p00, p01, p02 = p[0, 0], p[0, 1], p[0, 2]
    p10, p11, p12 = p[1, 0], p[1, 1], p[1, 2]
    p20, p21, p22 = p[2, 0], p[2, 1], p[2, 2]
    one, two, three = inverse[0], inverse[1], inverse[2]
    m0, m1, m2 = d.of_moment[0, j], d.of_moment[1, j], d.of_moment[2, j]
    for i in range(n):
        a = fma(-passage, block[PASSED + i], fma(rate, block[SECONDS + i], start))
        a = fma(-turn, block[Y + i], a)
        x = fma(block[BASIS + 3 * BLOCK + i], second, block[BASIS + 6 * BLOCK + i] * third)
        y = fma(block[BASIS + 4 * BLOCK + i], second, block[BASIS + 7 * BLOCK + i] * third)
        z = fma(block[BASIS + 5 * BLOCK + i], second, block[BASIS + 8 * BLOCK + i] * third)
        x = fma(block[BASIS + i], a, x) + ox
        y = fma(block[BASIS + BLOCK + i], a, y) + oy
        z = fma(block[BASIS + 2 * BLOCK + i], a, z) + oz
        ux = ix - fma(y, lz, -z * ly)
        uy = iy - fma(z, lx, -x * lz)
        uz = iz - fma(x, ly, -y * lx)
        # to body axes: the vector part of q* u q
        qw, qx = block[WXYZ + i], -block[WXYZ + BLOCK + i]
        qy, qz = -block[WXYZ + 2 * BLOCK + i], -block[WXYZ + 3 * BLOCK + i]
        tx = 2.0 * fma(qy, uz, -qz * uy)
        ty = 2.0 * fma(qz, ux, -qx * uz)
        tz = 2.0 * fma(qx, uy, -qy * ux)
        bx = fma(qw, tx, ux) + fma(qy, tz, -qz * ty)
        by = fma(qw, ty, uy) + fma(qz, tx, -qx * tz)
        bz = fma(qw, tz, uz) + fma(qx, ty, -qy * tx)
        wx, wy, wz = block[OMEGA + i], block[OMEGA + BLOCK + i], block[OMEGA + 2 * BLOCK + i]
        ax = fma(p00, bx, fma(p10, by, p20 * bz)) - m0 * fma(p00, wx, fma(p10, wy, p20 * wz))
        ay = fma(p01, bx, fma(p11, by, p21 * bz)) - m1 * fma(p01, wx, fma(p11, wy, p21 * wz))
        az = fma(p02, bx, fma(p12, by, p22 * bz)) - m2 * fma(p02, wx, fma(p12, wy, p22 * wz))
        bx, by, bz = one * ax, two * ay, three * az
        block[FOUND + i] = fma(p00, bx, fma(p01, by, p02 * bz))
        block[FOUND + BLOCK + i] = fma(p10, bx, fma(p11, by, p12 * bz))
        block[FOUND + 2 * BLOCK + i] = fma(p20, bx, fma(p21, by, p22 * bz))


@force_inlined
def copy_column(block, row, column, first, last, out):
    """Copy the three rows found to epochs first to last of a column of an array (B, 3, P, T)."""
    x, y, z = out[row, 0, column], out[row, 1, column], out[row, 2, column]
    x, y, z = x[first:last], y[first:last], z[first:last]
    for i in range(len(x)):
        x[i] = block[FOUND + i]
    for i in range(len(y)):
        y[i] = block[FOUND + BLOCK + i]
    for i in range(len(z)):
        z[i] = block[FOUND + 2 * BLOCK + i]


@force_inlined
def start_sums(n, rows, block):
    """Set the rows of the sums of products to 0."""
    for k in range(rows):
        for i in range(n):
            block[SUMS + k * BLOCK + i] = 0.0


@force_inlined
def keep_turn(n, block):
    """Keep the change of attitude while that of the angular velocity is found."""
    for i in range(n):
        block[TURNED + i] = block[FOUND + i]
        block[TURNED + BLOCK + i] = block[FOUND + BLOCK + i]
        block[TURNED + 2 * BLOCK + i] = block[FOUND + 2 * BLOCK + i]


@force_inlined
def add_products(n, block):
    """Add the products of the rows found: xx, xy, yy, xz, yz, zz."""
    for i in range(n):
        x, y, z = block[FOUND + i], block[FOUND + BLOCK + i], block[FOUND + 2 * BLOCK + i]
        block[SUMS + i] = fma(x, x, block[SUMS + i])
        block[SUMS + BLOCK + i] = fma(x, y, block[SUMS + BLOCK + i])
        block[SUMS + 2 * BLOCK + i] = fma(y, y, block[SUMS + 2 * BLOCK + i])
        block[SUMS + 3 * BLOCK + i] = fma(x, z, block[SUMS + 3 * BLOCK + i])
        block[SUMS + 4 * BLOCK + i] = fma(y, z, block[SUMS + 4 * BLOCK + i])
        block[SUMS + 5 * BLOCK + i] = fma(z, z, block[SUMS + 5 * BLOCK + i])


@force_inlined
def add_products_of_rates(n, block):
    """Add the products of the change of angular velocity with that of attitude and with itself."""
    for i in range(n):
        x, y, z = block[TURNED + i], block[TURNED + BLOCK + i], block[TURNED + 2 * BLOCK + i]
        u = block[FOUND + i]
        block[SUMS + 6 * BLOCK + i] = fma(x, u, block[SUMS + 6 * BLOCK + i])
        block[SUMS + 7 * BLOCK + i] = fma(y, u, block[SUMS + 7 * BLOCK + i])
        block[SUMS + 8 * BLOCK + i] = fma(z, u, block[SUMS + 8 * BLOCK + i])
        block[SUMS + 9 * BLOCK + i] = fma(u, u, block[SUMS + 9 * BLOCK + i])
        v = block[FOUND + BLOCK + i]
        block[SUMS + 10 * BLOCK + i] = fma(x, v, block[SUMS + 10 * BLOCK + i])
        block[SUMS + 11 * BLOCK + i] = fma(y, v, block[SUMS + 11 * BLOCK + i])
        block[SUMS + 12 * BLOCK + i] = fma(z, v, block[SUMS + 12 * BLOCK + i])
        block[SUMS + 13 * BLOCK + i] = fma(u, v, block[SUMS + 13 * BLOCK + i])
        block[SUMS + 14 * BLOCK + i] = fma(v, v, block[SUMS + 14 * BLOCK + i])
        w = block[FOUND + 2 * BLOCK + i]
        block[SUMS + 15 * BLOCK + i] = fma(x, w, block[SUMS + 15 * BLOCK + i])
        block[SUMS + 16 * BLOCK + i] = fma(y, w, block[SUMS + 16 * BLOCK + i])
        block[SUMS + 17 * BLOCK + i] = fma(z, w, block[SUMS + 17 * BLOCK + i])
        block[SUMS + 18 * BLOCK + i] = fma(u, w, block[SUMS + 18 * BLOCK + i])
        block[SUMS + 19 * BLOCK + i] = fma(v, w, block[SUMS + 19 * BLOCK + i])
        block[SUMS + 20 * BLOCK + i] = fma(w, w, block[SUMS + 20 * BLOCK + i])


@force_inlined
def copy_sums(block, row, start, stop, out):
    """Copy the sums, a lower triangle, to epochs of symmetric matrices (B, D, D, T)."""
    number = 0
    for k in range(out.shape[1]):
        for j in range(k + 1):
            below, above = out[row, k, j], out[row, j, k]
            below, above = below[start:stop], above[start:stop]
            first = SUMS + number * BLOCK
            sums = block[first : first + len(below)]
            for i in range(len(below)):
                below[i] = sums[i]
            for i in range(len(above)):
                above[i] = sums[i]
            number += 1
