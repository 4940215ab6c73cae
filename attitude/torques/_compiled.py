"""Compiled functions of the built-in torques; `attitude._solver.torqued_step` calls them.

Each takes TDB seconds t, the attitude wxyz (4,) body to ICRF, the angular velocity omega (3,) in
rad/s over the body axes, the samples at t (for a path: a position (3,) in m, ICRF axes) and the
parameters p, and fills out[0:3] over the body axes, N m.  Functions named ..._slope take a vector y
(3,) in place of omega; see `attitude.torques._torque.Torque.slope_address`.
"""

from __future__ import annotations

import math

from attitude._compilation.callbacks import callback, reduction_callback
from attitude._compilation.decorators import subroutine
from attitude._compilation.pointers import number, vector
from attitude._solver.kernel import turned_by


@subroutine
def _to_body(q, x, y, z):
    """q* v q: a vector (x, y, z) of ICRF axes over the body axes."""
    return turned_by((q[0], -q[1], -q[2], -q[3]), (x, y, z))


@subroutine
def _direction(q, samples):
    """Unit vector in body axes towards a sampled position, and its distance."""
    x, y, z = samples[0], samples[1], samples[2]
    r = math.sqrt(x * x + y * y + z * z)
    return _to_body(q, x / r, y / r, z / r), r


@subroutine
def _symmetric(p, k, v):
    """A symmetric matrix times a vector; p[k:k + 6]: the upper triangle by rows."""
    x, y, z = v
    return (
        p[k] * x + p[k + 1] * y + p[k + 2] * z,
        p[k + 1] * x + p[k + 3] * y + p[k + 4] * z,
        p[k + 2] * x + p[k + 4] * y + p[k + 5] * z,
    )


@subroutine
def _cross(u, v):
    """u x v."""
    return (
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    )


@callback
def gravity_gradient(t, wxyz, omega, samples, p, out):
    """3 GM / r^3 u x I u; p: GM, the tensor (6)."""
    u, r = _direction(wxyz, samples)
    n = _cross(u, _symmetric(p, 1, u))
    c = 3.0 * p[0] / (r * r * r)
    out[0], out[1], out[2] = c * n[0], c * n[1], c * n[2]


@callback
def gravity_gradient_slope(t, wxyz, y, samples, p, out):
    """Derivatives of N . y by turns about the body axes, N being that of `gravity_gradient`."""
    u, r = _direction(wxyz, samples)
    y = y[0], y[1], y[2]
    # d(u x I u . y)/du = I u x y + I (y x u)
    one, two = _cross(_symmetric(p, 1, u), y), _symmetric(p, 1, _cross(y, u))
    n = _cross((one[0] + two[0], one[1] + two[1], one[2] + two[2]), u)
    c = 3.0 * p[0] / (r * r * r)
    out[0], out[1], out[2] = c * n[0], c * n[1], c * n[2]


@callback
def eddy_current(t, wxyz, omega, samples, p, out):
    """(M (w x B - B')) x B; samples: B and B' over ICRF axes; p: M (6)."""
    field = _to_body(wxyz, samples[0], samples[1], samples[2])
    rate = _to_body(wxyz, samples[3], samples[4], samples[5])
    x, y, z = _cross((omega[0], omega[1], omega[2]), field)
    n = _cross(_symmetric(p, 0, (x - rate[0], y - rate[1], z - rate[2])), field)
    out[0], out[1], out[2] = n[0], n[1], n[2]


@callback
def magnetic_dipole(t, wxyz, omega, samples, p, out):
    """m x B; samples: B over ICRF axes; p: the moment m (3)."""
    n = _cross((p[0], p[1], p[2]), _to_body(wxyz, samples[0], samples[1], samples[2]))
    out[0], out[1], out[2] = n[0], n[1], n[2]


@callback
def magnetic_dipole_slope(t, wxyz, y, samples, p, out):
    """Derivatives of N . y by turns about the body axes, N being that of `magnetic_dipole`."""
    # d(m x B . y)/dB = y x m
    gradient = _cross((y[0], y[1], y[2]), (p[0], p[1], p[2]))
    n = _cross(gradient, _to_body(wxyz, samples[0], samples[1], samples[2]))
    out[0], out[1], out[2] = n[0], n[1], n[2]


@callback
def constant(t, wxyz, omega, samples, p, out):
    """N; p: the torque N (3)."""
    out[0], out[1], out[2] = p[0], p[1], p[2]


@callback
def constant_slope(t, wxyz, y, samples, p, out):
    """y x N: without a potential, the whole commutator with the free motion; p: the torque N."""
    n = _cross((y[0], y[1], y[2]), (p[0], p[1], p[2]))
    out[0], out[1], out[2] = n[0], n[1], n[2]


@callback
def linear_damping(t, wxyz, omega, samples, p, out):
    """-C w; p: C by rows (9)."""
    x, y, z = omega[0], omega[1], omega[2]
    for k in range(3):
        out[k] = -(p[3 * k] * x + p[3 * k + 1] * y + p[3 * k + 2] * z)


@callback
def internal_dissipation(t, wxyz, omega, samples, p, out):
    """A slip in rad/s: strength times l x w, l along the momentum; p: strength, tensor (6)."""
    w = omega[0], omega[1], omega[2]
    x, y, z = _symmetric(p, 1, w)
    size = math.sqrt(x * x + y * y + z * z)
    c = p[0] / size if size > 0.0 else 0.0
    n = _cross((x, y, z), w)
    out[0], out[1], out[2] = c * n[0], c * n[1], c * n[2]


@callback
def inertia_history(t, wxyz, omega, samples, p, out):
    """A slip in rad/s: -(I + D)^-1 D w; samples: the change D (6) of the tensor; p: I (6)."""
    w = omega[0], omega[1], omega[2]
    x, y, z = _symmetric(samples, 0, w)
    a, b, c = p[0] + samples[0], p[1] + samples[1], p[2] + samples[2]
    d, e, f = p[3] + samples[3], p[4] + samples[4], p[5] + samples[5]
    # cofactors; a matrix that is not positive leaves NaN
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * aa + b * bb + c * cc
    if a > 0.0 and a * d - b * b > 0.0 and determinant > 0.0:
        s = -1.0 / determinant
        out[0] = s * (aa * x + bb * y + cc * z)
        out[1] = s * (bb * x + (a * f - c * c) * y + (b * c - a * e) * z)
        out[2] = s * (cc * x + (b * c - a * e) * y + (a * d - b * b) * z)


@subroutine
def _weights(x):
    """Weights of four equally spaced values, for x between the second (0) and the third (1)."""
    return (
        -x * (x - 1.0) * (x - 2.0) / 6.0,
        (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
        -(x + 1.0) * x * (x - 2.0) / 2.0,
        (x + 1.0) * x * (x - 1.0) / 6.0,
    )


@subroutine
def _place(value, first, inverse, count):
    """The first of four nodes about a value within the table, and the place after the second."""
    at = min(max((value - first) * inverse, 0.0), count - 1.0)
    begin = min(max(math.floor(at) - 1.0, 0.0), count - 4.0)
    return int(begin), at - begin - 1.0


@callback
def rheological_dissipation(t, wxyz, omega, samples, p, out):
    """As `internal_dissipation`, with a strength by energy and momentum from a table.

    p: moments A <= B <= C; their axes by rows; first node, inverse of the spacing and number of
    nodes of ln(L/C) and of the logarithm of share/rest; logarithms of strengths near the short and
    near the long axis.
    """
    a, b, c = p[0], p[1], p[2]
    x, y, z = omega[0], omega[1], omega[2]
    u = p[3] * x + p[4] * y + p[5] * z
    v = p[6] * x + p[7] * y + p[8] * z
    w = p[9] * x + p[10] * y + p[11] * z
    # over the principal axes: momentum, and what is left of L^2 - 2 B T
    hu, hv, hw = a * u, b * v, c * w
    size = math.sqrt(hu * hu + hv * hv + hw * hw)
    apart = c * (c - b) * w * w - a * (b - a) * u * u
    if apart >= 0.0:
        table = 0
        share = b * (a * u * u * (c - a) + b * v * v * (c - b))
        margin = c * apart
    else:
        table = 1
        share = b * (c * w * w * (c - a) + b * v * v * (b - a))
        margin = -a * apart
    strength = 0.0
    if size > 0.0 and share > 0.0:
        logarithm = math.log(share / margin) if margin > share * 1e-30 else 100.0
        rates, shares = int(p[14]), int(p[17])
        i, fast = _place(math.log(size / c), p[12], p[13], p[14])
        j, between = _place(logarithm, p[15], p[16], p[17])
        by_rate, by_share = _weights(fast), _weights(between)
        values = vector(p, 18 + 2 * rates * shares)[18:].reshape(2, rates, shares)
        total = 0.0
        for k in range(4):
            row = 0.0
            for m in range(4):
                row += by_share[m] * values[table, i + k, j + m]
            total += by_rate[k] * row
        strength = math.exp(total) / size
    n = _cross((hu, hv, hw), (u, v, w))
    out[0] = strength * (p[3] * n[0] + p[6] * n[1] + p[9] * n[2])
    out[1] = strength * (p[4] * n[0] + p[7] * n[1] + p[10] * n[2])
    out[2] = strength * (p[5] * n[0] + p[8] * n[1] + p[11] * n[2])


@reduction_callback
def solar_radiation(t, wxyz, omega, samples, p, out):
    """Torque of light pressure on flat facets that face the Sun.

    samples: the body's position from the Sun; p: pressure times distance squared (N), the count of
    facets, and rows with a number for each facet: area, normal (3 rows), arm (3), arm x normal (3),
    fractions reflected diffusely and mirrored.
    """
    back, r = _direction(wxyz, samples)
    sx, sy, sz = -back[0], -back[1], -back[2]
    count = int(p[1])
    rows = vector(p, 2 + 12 * count)[2:].reshape(12, count)
    # sums of the arms, weighted by the area that takes a push along the sunlight, and of
    # arm x normal, weighted by that along the normal
    ax = ay = az = bx = by = bz = 0.0
    for k in range(count):
        cosine = max(rows[1, k] * sx + rows[2, k] * sy + rows[3, k] * sz, 0.0)
        size, mirrored = rows[0, k] * cosine, rows[11, k]
        along_sun = size * (1.0 - mirrored)
        along_normal = size * 2.0 * (mirrored * cosine + rows[10, k] * (1.0 / 3.0))
        ax += along_sun * rows[4, k]
        ay += along_sun * rows[5, k]
        az += along_sun * rows[6, k]
        bx += along_normal * rows[7, k]
        by += along_normal * rows[8, k]
        bz += along_normal * rows[9, k]
    n = _cross((ax, ay, az), (sx, sy, sz))
    pressure = -p[0] / (r * r)
    out[0], out[1], out[2] = pressure * (n[0] + bx), pressure * (n[1] + by), pressure * (n[2] + bz)


@subroutine
def _pushed(p, k, sun):
    """Area of facet k pushed along the light, and along its normal; p as `solar_radiation`."""
    cosine = max(p[1, k] * sun[0] + p[2, k] * sun[1] + p[3, k] * sun[2], 0.0)
    size, mirrored = p[0, k] * cosine, p[11, k]
    return size * (1.0 - mirrored), size * 2.0 * (mirrored * cosine + p[10, k] * (1.0 / 3.0))


@subroutine
def _on_face(x, y, z):
    """The face of the cube of `light_curve._visibility` that a direction meets, and its place."""
    ax, ay, az = abs(x), abs(y), abs(z)
    if ay < ax and az < ax:
        face, w, u, v = 0, x, y, z
    elif az > ay:
        face, w, u, v = 4, z, x, y
    else:
        face, w, u, v = 2, y, z, x
    if w < 0.0:
        face += 1
    return face, _evened(u / abs(w)), _evened(v / abs(w))


@subroutine
def _evened(u):
    """As `light_curve._sums.evened`, where sums keep their order."""
    s = math.sqrt(1.0 + 3.0 * abs(u)) - 1.0
    return s if u >= 0.0 else -s


@reduction_callback
def shaded_radiation(t, wxyz, omega, samples, p, out):
    """As `solar_radiation`, on the shares of facets that are free of shadows.

    p: the address of a table (6 (n + 2)^2, N) of these shares by cell of the sky, n, and what
    `solar_radiation` takes.
    """
    back, r = _direction(wxyz, samples)
    sun = -back[0], -back[1], -back[2]
    cells, count = int(p[1]), int(p[3])
    rows = vector(p, 4 + 12 * count)[4:].reshape(12, count)
    face, u, v = _on_face(sun[0], sun[1], sun[2])
    # between the middles of four cells, of those of the face and one row around them
    x, y = 0.5 * (u + 1.0) * cells + 0.5, 0.5 * (v + 1.0) * cells + 0.5
    i, j, wide = min(max(int(x), 0), cells), min(max(int(y), 0), cells), cells + 2
    x, y = x - i, y - j
    first = ((face * wide + j) * wide + i) * count
    table, right, above = int(p[0]), count, wide * count
    ax = ay = az = bx = by = bz = 0.0
    for k in range(count):
        along_sun, along_normal = _pushed(rows, k, sun)
        if along_sun > 0.0 or along_normal > 0.0:
            at = first + k
            lower = (1.0 - x) * number(table, at) + x * number(table, at + right)
            upper = (1.0 - x) * number(table, at + above) + x * number(table, at + above + right)
            lit = (1.0 - y) * lower + y * upper
            along_sun, along_normal = lit * along_sun, lit * along_normal
            ax += along_sun * rows[4, k]
            ay += along_sun * rows[5, k]
            az += along_sun * rows[6, k]
            bx += along_normal * rows[7, k]
            by += along_normal * rows[8, k]
            bz += along_normal * rows[9, k]
    n = _cross((ax, ay, az), sun)
    pressure = -p[2] / (r * r)
    out[0], out[1], out[2] = pressure * (n[0] + bx), pressure * (n[1] + by), pressure * (n[2] + bz)
