"""Tables of mean rates over the energy of a rotation, of torques that depend on one direction.

A torque N(u), u the unit vector of the direction over the principal axes, is a sum of spherical
harmonics with vector coefficients.  A mean over the precession multiplies the part of degree l by
P_l(c), c the cosine between momentum and direction: the mean of Y_lm over a cone about l is
P_l(c) Y_lm(l), that of Y_lm(u) times the unit vector across l is P_l'(c) sin/(l (l + 1)) grad Y_lm.
Four sums over the polhode are left for each degree, functions of the energy alone; cubic splines
hold them for each of the four regions.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from attitude._compilation.decorators import entry_point, subroutine
from attitude._textfiles import kept_arrays
from attitude.averaged._polhode import LAM_PLUS, direction, form, jacobi, theta_constants
from attitude.averaged._rates import torques_at

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FloatArray
    from attitude.averaged._polhode import Axes

# The coordinate ln(exp(h) - 1) of the tables: from h = 1e-9, in steps at which the error of cubic
# splines is 1e-7 of the largest entry, to a tilt of exp(-10) from the farther axis, beyond which
# the tables are constant.
_FIRST: Final = math.log(1e-9)
_STEP: Final = 0.08
_TAIL: Final = 21.0
# To be raised when the numbers of a table change.
_METHOD: Final = 2
_LARGEST: Final = 1 << 30  # bytes of all tables on disk together


def coordinates(axes: Axes) -> FloatArray:
    """The nodes (n + 1,) of the tables of a body."""
    last = _TAIL + abs(axes.separatrix)
    count = math.ceil((last - _FIRST) / _STEP)
    nodes: FloatArray = _FIRST + _STEP * np.arange(count + 1.0)
    return nodes


def distances(x: FloatArray) -> FloatArray:
    """h at nodes of the tables."""
    h: FloatArray = np.logaddexp(0.0, x).astype(np.float64)
    return h


def spline(x: FloatArray, values: FloatArray) -> FloatArray:
    """Coefficients (n, 4, C) of the cubic spline through values (n + 1, C), highest power first."""
    from scipy.interpolate import CubicSpline

    return np.ascontiguousarray(np.moveaxis(CubicSpline(x, values, axis=0).c, 0, 1))


# ---- Spherical harmonics of a torque


@subroutine
def legendre(degree, z, steps, out):
    """Orthonormal functions without sin^m: A_lm(z), (degree + 2, degree + 2); steps (2, ...)."""
    out[0, 0] = 0.5 / math.sqrt(math.pi)
    for m in range(1, degree + 1):
        out[m, m] = steps[0, m, m] * out[m - 1, m - 1]
    for m in range(degree + 1):
        for n in range(m + 1, degree + 1):
            value = steps[0, n, m] * z * out[n - 1, m]
            if n - 2 >= m:
                value -= steps[1, n, m] * out[n - 2, m]
            out[n, m] = value


def _steps(degree: int) -> FloatArray:
    """Factors (3, degree + 2, degree + 2) of `legendre`, and those of d/dz."""
    out = np.zeros((3, degree + 2, degree + 2))
    for m in range(degree + 1):
        if m:
            out[0, m, m] = math.sqrt(3.0) if m == 1 else math.sqrt((2.0 * m + 1.0) / (2.0 * m))
        for n in range(m, degree + 1):
            if n > m:
                out[0, n, m] = math.sqrt((4.0 * n * n - 1.0) / (n * n - m * m))
                out[2, n, m] = math.sqrt((n - m) * (n + m + 1.0) * (0.5 if m == 0 else 1.0))
            if n - 2 >= m:
                top = (2.0 * n + 1.0) * (n + m - 1.0) * (n - m - 1.0)
                out[1, n, m] = math.sqrt(top / ((2.0 * n - 3.0) * (n + m) * (n - m)))
    return out


@entry_point
def fill_legendre(degree, z, steps, out):
    """Fill A_lm (K, degree + 2, degree + 2) at z (K,)."""
    for k in range(len(z)):
        legendre(degree, z[k], steps, out[k])


# Nodes of the quadrature for each degree: kinks, where a facet turns into the light, alias.
_FINE: Final = 6


def harmonics(field: Callable[[FloatArray], FloatArray], degree: int) -> FloatArray:
    """Coefficients (3, 2, degree + 1, degree + 1) of a torque: component, cos or sin, l, m.

    field: of unit vectors (K, 3) over the principal axes, returns torques (K, 3) over them.
    """
    count = _FINE * (degree + 1)
    z, weights = np.polynomial.legendre.leggauss(count)
    longitudes = math.pi * (np.arange(2 * count) + 0.5) / count
    sines = np.sqrt(1.0 - z * z)
    u = np.empty((count, 2 * count, 3))
    u[..., 0] = sines[:, None] * np.cos(longitudes)
    u[..., 1] = sines[:, None] * np.sin(longitudes)
    u[..., 2] = z[:, None]
    torques = field(u.reshape(-1, 3)).reshape(count, 2 * count, 3)
    orders = np.arange(degree + 1)
    phases = orders[:, None] * longitudes
    functions = np.zeros((count, degree + 2, degree + 2))
    fill_legendre(degree, z, _steps(degree), functions)
    functions = functions[:, : degree + 1, : degree + 1] * sines[:, None, None] ** orders
    coefficients = np.empty((3, 2, degree + 1, degree + 1))
    for k, wave in enumerate((np.cos(phases), np.sin(phases))):
        parts = np.einsum("mp,zpi->zmi", wave, torques, optimize=True)
        parts *= weights[:, None, None] * (math.pi / count)
        coefficients[:, k] = np.einsum("zlm,zmi->ilm", functions, parts, optimize=True)
    return coefficients


@subroutine
def sums_at(degree, x, rate, coefficients, steps, values, waves, weight, out):
    """Add the four sums of each degree at one l to out (degree + 1, 4), times a weight."""
    legendre(degree, x[2], steps, values)
    waves[0, 0], waves[1, 0] = 1.0, 0.0
    for m in range(1, degree + 1):
        waves[0, m] = x[0] * waves[0, m - 1] - x[1] * waves[1, m - 1]
        waves[1, m] = x[0] * waves[1, m - 1] + x[1] * waves[0, m - 1]
    for n in range(degree + 1):
        n0 = n1 = n2 = radial = across = 0.0
        for m in range(n + 1):
            a = values[n, m]
            slope = steps[2, n, m] * values[n, m + 1] if m < n else 0.0
            for k in range(2):
                v = a * waves[k, m]
                gx = gy = 0.0
                if m > 0:
                    # d/dx and d/dy of Re and Im (x + i y)^m
                    if k == 0:
                        gx, gy = a * m * waves[0, m - 1], -a * m * waves[1, m - 1]
                    else:
                        gx, gy = a * m * waves[1, m - 1], a * m * waves[0, m - 1]
                gz = slope * waves[k, m]
                dot = gx * x[0] + gy * x[1] + gz * x[2]
                gx, gy, gz = gx - dot * x[0], gy - dot * x[1], gz - dot * x[2]
                c0, c1, c2 = (
                    coefficients[0, k, n, m],
                    coefficients[1, k, n, m],
                    coefficients[2, k, n, m],
                )
                n0 += c0 * v
                n1 += c1 * v
                n2 += c2 * v
                radial += c0 * gx + c1 * gy + c2 * gz
                across += (
                    c0 * (x[1] * gz - x[2] * gy)
                    + c1 * (x[2] * gx - x[0] * gz)
                    + c2 * (x[0] * gy - x[1] * gx)
                )
        out[n, 0] += weight * (n0 * x[0] + n1 * x[1] + n2 * x[2])
        out[n, 1] += weight * (n0 * rate[0] + n1 * rate[1] + n2 * rate[2])
        out[n, 2] += weight * radial
        out[n, 3] += weight * across


@entry_point
def fill_sums(degree, axes, region, h, coefficients, steps, out):
    """Fill the means (H, degree + 1, 4) of `sums_at` over the polhodes of a region at h (H,)."""
    values = np.zeros((degree + 2, degree + 2))
    waves = np.zeros((2, degree + 2))
    out[:] = 0.0
    for i in range(len(h)):
        constants = theta_constants(h[i])
        shape = form(axes, region, h[i])
        p, complement = shape[0] * shape[0], shape[1] * shape[1]
        # as many nodes as 1e-6 takes near the separatrix, and powers of sin theta far from it
        k = constants[0]
        ratio = k * constants[2] / (0.5 * math.pi) if not constants[1] else 0.5
        share = max(ratio, shape[0] if region < LAM_PLUS else shape[1])
        count = 10 + int(1.15 * (9 + degree) * share)
        for j in range(count):
            x = direction(region, shape, jacobi(4.0 * k * (j + 0.5) / count, constants))
            rate = (
                complement * x[0] / (p * complement),
                shape[2] * x[1] / (p * complement),
                -p * x[2] / (p * complement),
            )
            sums_at(degree, x, rate, coefficients, steps, values, waves, 1.0 / count, out[i])


@entry_point
def fill_arcs(degree, arcs, seconds, gamma, coefficients, steps, out):
    """Fill integrals (4, degree + 1, 4) of `sums_at` along the arcs; gamma by p (1 - p)."""
    values = np.zeros((degree + 2, degree + 2))
    waves = np.zeros((2, degree + 2))
    out[:] = 0.0
    for i in range(4):
        for j in range(len(seconds)):
            x = (arcs[i, j, 0], arcs[i, j, 1], arcs[i, j, 2])
            rate = (gamma[0] * x[0], gamma[1] * x[1], gamma[2] * x[2])
            sums_at(degree, x, rate, coefficients, steps, values, waves, seconds[j], out[i])


def field_of(
    address: int, parameters: FloatArray, axes: Axes, columns: int
) -> Callable[[FloatArray], FloatArray]:
    """A torque as a function of the direction of its sampled vector, over the principal axes."""

    def field(u: FloatArray) -> FloatArray:
        samples = np.zeros((len(u), columns))
        samples[:, :3] = u @ axes.matrix.T
        wxyz = np.zeros((len(u), 4))
        wxyz[:, 0] = 1.0
        out = np.empty((len(u), 3))
        zero = np.zeros((len(u), 3))
        torques_at(address, parameters.ctypes.data, zero[:, 0].copy(), wxyz, zero, samples, out)
        return out @ axes.matrix

    return field


def weights(degree: int) -> FloatArray:
    """Factors (degree + 1, 4) of the sums of each degree n: highest coefficients of P_n and P_n'.

    k_n = (2 n - 1)!!/n! of P_n; P_n' has n k_n, and is divided by n (n + 1) in the means.
    """
    n = np.arange(1.0, degree + 1.0)
    highest = np.concatenate([[1.0], np.cumprod((2.0 * n - 1.0) / n)])
    slopes = highest / np.arange(1.0, degree + 2.0)
    return np.stack([highest, highest, slopes, slopes], axis=1)


def sums_of(coefficients: FloatArray, axes: Axes) -> tuple[FloatArray, FloatArray]:
    """Means (4 regions, n + 1, C) at `coordinates`, integrals (4 arcs, C = 4 (l + 1)), weighted."""
    degree = coefficients.shape[-1] - 1
    steps, h = _steps(degree), distances(coordinates(axes))
    means = np.empty((4, len(h), degree + 1, 4))
    for region in range(4):
        fill_sums(degree, axes.numbers, region, h, coefficients, steps, means[region])
    arcs, seconds = axes.arcs
    on_arcs = np.empty((4, degree + 1, 4))
    p = 1.0 / (1.0 + math.exp(-axes.separatrix))
    # gamma 2 is 0 on the separatrix
    gamma = np.array([1.0 / p, 0.0, -1.0 / (1.0 - p)])
    fill_arcs(degree, arcs, seconds, gamma, coefficients, steps, on_arcs)
    means *= weights(degree)
    on_arcs *= weights(degree)
    return means.reshape(4, len(h), -1), on_arcs.reshape(4, -1)


# ---- Tables on disk


def kept(
    key: tuple[object, ...],
    arrays: tuple[FloatArray, ...],
    make: Callable[[], dict[str, FloatArray]],
) -> dict[str, FloatArray]:
    """What `make` returns, from the disk where a process has made it: by key and `arrays`."""
    file = kept_arrays.file_of("torque", repr((_METHOD, _FINE, _STEP, *key)), *arrays)
    stored = kept_arrays.read(file)
    if stored and all(np.all(np.isfinite(array)) for array in stored.values()):
        return stored
    computed = make()
    kept_arrays.write(file, computed, _LARGEST)
    return computed
