"""The compiled functions of the torques that are shipped; see `attitude.solution.march`.

Each is given body axes throughout and fills out[0:3].
"""

import math

from numba import cfunc, njit, types

_POINTER = types.CPointer(types.float64)
SIGNATURE = types.void(types.float64, _POINTER, _POINTER, _POINTER, _POINTER, _POINTER)


def door(function):
    """Compile as a C function, kept on disk where that is possible."""
    try:
        return cfunc(SIGNATURE, cache=True, error_model="numpy")(function)
    except RuntimeError:
        return cfunc(SIGNATURE, error_model="numpy")(function)


@njit(error_model="numpy")
def _to_body(q, x, y, z):
    """q* v q."""
    w, a, b, c = q[0], -q[1], -q[2], -q[3]
    d, e, f = 2.0 * (b * z - c * y), 2.0 * (c * x - a * z), 2.0 * (a * y - b * x)
    return (
        x + w * d + (b * f - c * e),
        y + w * e + (c * d - a * f),
        z + w * f + (a * e - b * d),
    )


@njit(error_model="numpy")
def _direction(q, given):
    """Unit vector in body axes towards a sampled position, and its distance."""
    x, y, z = given[0], given[1], given[2]
    r = math.sqrt(x * x + y * y + z * z)
    return _to_body(q, x / r, y / r, z / r), r


@njit(error_model="numpy")
def _symmetric(p, k, v):
    """A symmetric matrix, its six entries from p[k] on, times a vector."""
    x, y, z = v
    return (
        p[k] * x + p[k + 1] * y + p[k + 2] * z,
        p[k + 1] * x + p[k + 3] * y + p[k + 4] * z,
        p[k + 2] * x + p[k + 4] * y + p[k + 5] * z,
    )


@njit(error_model="numpy")
def _cross(u, v):
    return (
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    )


@door
def gravity_gradient(t, wxyz, omega, given, p, out):
    """3 GM / r^3 times u x I u; p: GM, the tensor (6), its inverse (6)."""
    u, r = _direction(wxyz, given)
    n = _cross(u, _symmetric(p, 1, u))
    c = 3.0 * p[0] / (r * r * r)
    out[0], out[1], out[2] = c * n[0], c * n[1], c * n[2]


@door
def gravity_gradient_of_force(t, wxyz, omega, given, p, out):
    """The torque of the potential -N . I^-1 N, N that of `gravity_gradient`."""
    u, r = _direction(wxyz, given)
    inertia_u = _symmetric(p, 1, u)
    y = _symmetric(p, 7, _cross(u, inertia_u))
    # d (n . I^-1 n) / du = 2 (I u x y + I (y x u))
    one, two = _cross(inertia_u, y), _symmetric(p, 1, _cross(y, u))
    n = _cross(u, (one[0] + two[0], one[1] + two[1], one[2] + two[2]))
    c = 3.0 * p[0] / (r * r * r)
    c = -2.0 * c * c
    out[0], out[1], out[2] = c * n[0], c * n[1], c * n[2]


@door
def constant(t, wxyz, omega, given, p, out):
    """p: the torque."""
    out[0], out[1], out[2] = p[0], p[1], p[2]


@door
def linear_damping(t, wxyz, omega, given, p, out):
    """-C w; p: C by rows (9)."""
    x, y, z = omega[0], omega[1], omega[2]
    for k in range(3):
        out[k] = -(p[3 * k] * x + p[3 * k + 1] * y + p[3 * k + 2] * z)


@door
def internal_dissipation(t, wxyz, omega, given, p, out):
    """A slip: strength times l x w, l the direction of the momentum; p: strength, tensor (6)."""
    w = omega[0], omega[1], omega[2]
    x, y, z = _symmetric(p, 1, w)
    size = math.sqrt(x * x + y * y + z * z)
    c = p[0] / size if size > 0.0 else 0.0
    n = _cross((x, y, z), w)
    out[0], out[1], out[2] = c * n[0], c * n[1], c * n[2]


@door
def solar_radiation(t, wxyz, omega, given, p, out):
    """Pressure on flat facets that see the Sun.

    given: the body's position from the Sun; p: pressure times distance squared (N), count, and
    for each facet area, normal (3), arm (3), fractions reflected diffusely and mirrored.
    """
    back, r = _direction(wxyz, given)
    sx, sy, sz = -back[0], -back[1], -back[2]
    pressure = p[0] / (r * r)
    x = y = z = 0.0
    for k in range(int(p[1])):
        j = 2 + 9 * k
        nx, ny, nz = p[j + 1], p[j + 2], p[j + 3]
        cosine = max(nx * sx + ny * sy + nz * sz, 0.0)
        diffuse, mirrored = p[j + 7], p[j + 8]
        size = -pressure * p[j] * cosine
        along_sun = size * (1.0 - mirrored)
        along_normal = size * 2.0 * (mirrored * cosine + diffuse / 3.0)
        fx = along_sun * sx + along_normal * nx
        fy = along_sun * sy + along_normal * ny
        fz = along_sun * sz + along_normal * nz
        ax, ay, az = p[j + 4], p[j + 5], p[j + 6]
        x += ay * fz - az * fy
        y += az * fx - ax * fz
        z += ax * fy - ay * fx
    out[0], out[1], out[2] = x, y, z
