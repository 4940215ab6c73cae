"""The free rotation in five numbers, the normal form of docs/derivation.md (section 15).

With E = exp(i (nutation_rate t + phase)), s = rho^4 and the precession exp(i precession_rate t),
the attitude of the body over axes with z along the momentum is the pair of polynomials

    A = 1 + sum (-1)^n s^(n^2) (X^(2n^2+n) E^(2n) + X^(2n^2-n) E^-(2n)),                    n >= 1
    b = -i rho sum (-1)^n s^(n^2+n) (X^(2n^2+n) E^-(2n+1) - X^(2n^2+3n+1) E^(2n+1)),        n >= 0
"""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._solver import codes
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import FloatArray


# Share by which rounding may move the moments of a lamina off all bodies.
_ROUNDED = 1e-11
# Series of the nome 0.21 or less: powers of n^2.
_TERMS = 7
# Nome below which one term is left of each series.
_SMALL_NOME = 1e-17
# Complex step of X, and of rho over itself: its square is below every rounding.
_STEP = 1e-30
# ln(rho^4 X^2) above which mc is less than 1e-285: squares of its root are nearly 0.
_SEPARATRIX = -0.03


class Elements(NamedTuple):
    """The normal form of a free rotation.

    Attributes
    ----------
    precession_rate : float
        rad/s: half of the mean rate of phi + psi, the angles about the momentum and about the axis
        about which the momentum circulates.
    nutation_rate : float
        rad/s, the mean rate of psi: positive in long-axis, negative in short-axis mode.  0 on the
        separatrix.
    phase : float
        rad, of the nutation at the epoch; motions whose phases differ by pi differ by the names of
        two axes alone.
    rho : float
        Amplitude of the nutation: the tangent of half the tilt of a symmetric body; 0 for rotation
        about an axis (its phase is then 0, its X that of a vanishing nutation), 1 on the
        separatrix.
    X : float
        Ellipticity of the nutation, 0 (a symmetric body) to 1 (the separatrix).
    """

    precession_rate: float
    nutation_rate: float
    phase: float
    rho: float
    X: float


def elements_of(c: Any) -> Elements:
    """The elements of a record of `records.CONSTANTS`."""
    if c["form"] == codes.UNIFORM:
        return _of_uniform(c)
    precession = 2.0 * math.pi * float(c["precession"][0])
    rate, phase = float(c["nutation"][0]), float(c["nutation0"][0])
    if c["form"] == codes.HYPERBOLIC:
        if c["winds"] == 0.0:
            return Elements(precession, 0.0, 0.0, 1.0, 1.0)
        rate, phase = 0.5 * rate, 0.5 * phase
    if c["stretch"] < math.inf:
        delta = 0.25 * math.pi * float(c["stretch"] * c["fraction"])
        x = math.exp(-2.0 * delta)
        rho = math.exp(delta - 0.25 * math.pi * float(c["stretch"]))
    else:
        x, rho = 0.0, 0.0
    if c["form"] == codes.TRIGONOMETRIC and rho < 0.5:
        # From the tilt, which keeps its digits where the nome underflows or is 0
        rho = float(c["wobble"]) / _half_tilt(rho**4, x, _one_less_x(c))
    turn = 2.0 * math.pi
    return Elements(precession, turn * rate, turn * phase, rho, x)


class Tangents(NamedTuple):
    """What the columns by the five elements need: weights (6, 5), amplitudes (3, 5) and by_third as
    in `records.TANGENTS`, and the change of the logarithms of the moments (3, 5), as given.
    """

    weights: FloatArray
    amplitudes: FloatArray
    by_third: tuple[float, float]
    log_moments: FloatArray


def tangents_by_elements(c: Any) -> Tangents:
    """Derivatives by elements of a `records.CONSTANTS`, by complex steps in series of `_form`."""
    hyperbolic = c["form"] == codes.HYPERBOLIC
    if c["form"] == codes.UNIFORM or (hyperbolic and c["winds"] == 0.0):
        raise AttitudeError(
            "the motion has no derivatives by its elements: in uniform rotation and on the "
            'separatrix they do not follow from the state. Take by="state".'
        )
    elements = elements_of(c)
    less = _one_less_x(c)
    weights, amplitudes, log_moments = np.zeros((6, 5)), np.zeros((3, 5)), np.zeros((3, 5))
    first, second = int(c["jacobi"][0]), int(c["jacobi"][1])
    order = [first, second, 3 - first - second]
    momentum = math.ldexp(np.linalg.norm(c["moments"][:, 0] * c["omega"][:, 0]), int(c["tempo"]))
    inverse, scale = momentum / c["moments"][order, 0], 1.0
    extremes = c["amplitudes"] / inverse
    cosines = extremes[2] * np.array([1.0, math.sqrt(c["mc"][0])])
    for k in range(5):
        # all is linear in the rates and the phase
        step = 1.0 if k < 3 else _STEP * (elements.rho if k == 3 else 1.0)
        moved = [complex(value, step if j == k else 0.0) for j, value in enumerate(elements)]
        form = _form(moved, complex(less, -step if k == 4 else 0.0), hyperbolic, cosines)
        scale = form.stretch.real
        weights[:, k] = [
            2.0 * (moved[0] - form.shift * moved[1]).imag,
            moved[1].imag / scale,
            moved[2].imag / scale,
            form.second.imag,
            form.third.imag,
            form.nome.imag,
        ]
        # over those of the state, which have the digits of a needle
        log_moments[order, k] = -form.inverse.imag / inverse
        amplitudes[:, k] = form.extremes.imag / extremes - log_moments[order, k]
        amplitudes[:, k] += form.quotients.imag / form.quotients.real
        for array in (weights, amplitudes, log_moments):
            array[:, k] /= step
    by_third = scale / (math.pi * form.third.real) if hyperbolic else 0.0
    return Tangents(weights, amplitudes, (by_third, 0.0), log_moments)


def _one_less_x(c: Any) -> float:
    """1 - X of a record."""
    return -math.expm1(-0.5 * math.pi * float(c["stretch"] * c["fraction"]))


def _of_uniform(c: Any) -> Elements:
    axis = int(c["circulates"])
    if axis < 0:
        raise AttitudeError(
            "the motion has no elements: at rest, of a sphere, about the middle axis, or about the "
            "equator of a symmetric body no nutation is defined."
        )
    axial = float(c["moments"][axis, 0])
    others = [float(c["moments"][k, 0]) for k in range(3) if k != axis]
    first = max(others, key=lambda moment: abs(moment - axial))
    second = min(others, key=lambda moment: abs(moment - axial))
    root = math.sqrt(1.0 + axial / first * abs((first - second) / (second - axial)))
    return Elements(
        precession_rate=2.0 * math.pi * float(c["precession"][0]),
        nutation_rate=2.0 * math.pi * float(c["psi_rate"]),
        phase=0.0,
        rho=0.0,
        X=(root - 1.0) / (root + 1.0),
    )


def _half_tilt(s: float, x: float, less: float) -> float:
    """The tangent of half the least tilt over rho; less = 1 - X."""
    top, low = less, 1.0
    for n in range(1, _TERMS):
        sign, ends = (-1.0) ** n, less * sum(x**j for j in range(2 * n + 1))
        top += sign * s ** (n * n + n) * x ** (2 * n * n + n) * ends
        low += sign * s ** (n * n) * x ** (2 * n * n - n) * (1.0 + x ** (2 * n))
    return top / low


def state_of(elements: Elements) -> tuple[FloatArray, FloatArray]:
    """Moments (3,), the greatest being 1, and angular velocity (3,) at the epoch, over the
    principal axes in the order of the solution: the momentum circulates about the third, the second
    is the middle one.
    """
    _check(elements)
    hyperbolic = elements.X > 0.0 and _log_nome(elements.rho, elements.X).real > -math.pi
    form = _form([complex(value) for value in elements], complex(1.0 - elements.X), hyperbolic)
    inverse = form.inverse.real
    ratios = inverse.max() / inverse if inverse.min() > 0.0 else np.array([np.nan] * 3)
    moments = ratios / ratios.max()
    largest = int(np.argmax(moments))
    others = moments.sum() - moments[largest]
    if not others >= 1.0 - _ROUNDED:
        raise AttitudeError(
            f"no body has {elements}: no moments that satisfy the triangle inequality precess at "
            "this rate with this nutation. Change precession_rate or nutation_rate."
        )
    if others < 1.0:
        moments[largest] = others
        moments /= others
    turns = round(elements.phase / math.pi)
    sign = -1.0 if hyperbolic and turns % 2 else 1.0
    z = (
        2j * (elements.phase - math.pi * turns) / form.stretch.real
        if hyperbolic
        else elements.phase
    )
    two, one, three, four = _thetas(form.nome, z)
    quotients = (
        [sign * four / two, sign * 1j * one / two, three / two]
        if hyperbolic
        else [two / four, -one / four, three / four]
    )
    return moments, (form.extremes * form.inverse * form.quotients * quotients).real


class _Form(NamedTuple):
    """What follows from the elements, real or with a complex step.

    Amplitudes of the angular velocity are extremes times inverse, factors of its quotients of theta
    functions, whose nome is given, these times quotients.
    """

    extremes: Any  # largest |z| along each axis
    inverse: Any  # L over each moment
    quotients: Any
    nome: complex
    stretch: complex  # T, or 1
    shift: complex  # d over pi/2, or 0
    second: complex  # ln rho, near the separatrix d
    third: complex  # X, near the separatrix Q'


def _form(
    elements: Sequence[complex], less: complex, hyperbolic: bool, cosines: Any = None
) -> _Form:
    """Moments and amplitudes in closed form (docs/derivation.md, section 15).

    less: 1 - X.  cosines (2,): of the least and the greatest tilt, if they are known better.

    The angular velocity is 2 lambda z + v' B_v, z the direction of the momentum and B_v the turn by
    the phase, and its component along axis i is that of z over I_i: with the ratio g_i of the two
    components, 1/I_i = (2 lambda + v' g_i)/L.
    """
    precession, nutation, _, rho, x = elements
    if hyperbolic:
        stretch = -_log_nome(rho, x) / math.pi
        d, third = -cmath.log(x) / (2.0 * stretch), cmath.exp(-math.pi / stretch)
        extremes, g = _near_separatrix(third, d)
        second, shift, nome = d, 2.0 / math.pi * d, third * third
    else:
        extremes, g = _apart(rho, x, less, cosines)
        second, third, nome = cmath.log(rho), x, rho * rho * x
        stretch, shift = complex(1.0), complex(0.0)
    inverse = 2.0 * (precession - shift * nutation) + nutation / stretch * g
    two, _, three, four = _thetas(nome, 0.0)
    quotients = [two / four, three / four, two / three]
    if not hyperbolic:
        quotients = [four / two, three / two, four / three]
    return _Form(extremes, inverse, np.array(quotients), nome, stretch, shift, second, third)


def _log_nome(rho: complex, x: complex) -> complex:
    """ln Q = -pi T."""
    return 4.0 * cmath.log(rho) + 2.0 * cmath.log(x)


def _thetas(q: complex, z: complex) -> tuple[complex, complex, complex, complex]:
    """theta2 and theta1 over 2 q^(1/4), theta3 and theta4; |Im z| at most |ln q|/2."""
    two, one, three, four = 0j, 0j, 1.0 + 0j, 1.0 + 0j
    for n in range(_TERMS if abs(q) > _SMALL_NOME else 1):
        sign, odd = (-1.0) ** n, q ** (n * n + n)
        two += odd * cmath.cos((2 * n + 1) * z)
        one += sign * odd * cmath.sin((2 * n + 1) * z)
        even = 2.0 * q ** ((n + 1) ** 2) * cmath.cos((2 * n + 2) * z)
        three += even
        four -= sign * even
    return two, one, three, four


def _apart(rho: complex, x: complex, less: complex, cosines: Any) -> tuple[Any, Any]:
    """The largest |z_i| of each axis, and g_i, by series in rho and X.

    At the phases 0 and pi/2 the pair is (low, -i rho top) and (low, -rho top) of two entries, V of
    section 15 is -rho wave and i rho wave.
    """
    square = rho * rho
    s, q = square * square, square * x
    top, low, wave = np.zeros(2, complex), np.ones(2, complex), np.zeros(2, complex)
    norm, slope, product, at_zero = 1.0 + 0j, 0j, 1.0 + 0j, 1.0 + 0j
    for n in range(_TERMS):
        loss, gain = less * sum(x**j for j in range(2 * n + 1)), 1.0 + x ** (2 * n + 1)
        sign, even = (-1.0) ** n, 1.0 + x ** (2 * n)
        top += s ** (n * n + n) * x ** (2 * n * n + n) * np.array([sign * loss, gain])
        wave += square ** (n * n + n) * x ** (n * n) * np.array([gain, sign * loss])
        if n > 0:
            low += s ** (n * n) * x ** (2 * n * n - n) * even * np.array([sign, 1.0])
            term = square ** (n * n) * x ** (n * n - n)
            norm += term * even
            slope += n * term * less * sum(x**j for j in range(2 * n))
            product += q ** (n * n + n)
            at_zero += 2.0 * sign * q ** (2 * n * n)
    tilt = rho * top / low  # tan of half of it
    wave *= at_zero * at_zero * product / (low**2 * (1.0 + tilt**2))
    flat, whole = 1.0 - tilt**2, 1.0 + tilt**2
    if cosines is not None:
        flat = whole.real * cosines + 1j * flat.imag
    # x cot, y cot and -x tan of the tilts
    turns = -wave * flat * low / top
    turns = np.append(turns, 4.0 * rho * wave[0] * tilt[0] / flat[0])
    sine = 2.0 * tilt / whole
    return np.array([*sine, flat[0] / whole[0]]), turns - 2.0 * slope / norm


def _near_separatrix(p: complex, d: complex) -> tuple[Any, Any]:
    """As `_apart`, by Q' and d: at y = 0 and at the end of a passage."""
    low, top, three, four = _thetas(p, d)
    _, wave, upright, at_zero = _thetas(p * p, 2.0 * d)
    size = _thetas(p, 0.0)[0] ** 2 * _thetas(p * p, 0.0)[3]
    slope = sum(n * p ** (2 * n * n) * cmath.sin(4 * n * d) for n in range(1, _TERMS))
    along = 8.0 * slope / upright
    square, middle = low * low + top * top, three * three + four * four
    cosine, sine = (low * low - top * top) / square, 2.0 * low * top / square
    turn = -2.0 * size * at_zero / square
    less = 16.0 * p * size * wave / middle * (three * three - four * four) / (2.0 * three * four)
    g = along + np.array([turn * cosine / sine, -less, -turn * sine / cosine])
    return np.array([sine, 2.0 * three * four / middle, cosine]), g


def _check(elements: Elements) -> None:
    values = np.array(elements, dtype=float)
    if values.shape != (5,) or not np.all(np.isfinite(values)):
        raise AttitudeError(f"elements are {elements}; give five finite numbers.")
    if elements.nutation_rate == 0.0:
        raise AttitudeError(
            "nutation_rate is 0, as on the separatrix; no one body follows from it. Give the "
            "moments and the angular velocity."
        )
    if not 0.0 < elements.rho < 1.0 or not 0.0 <= elements.X < 1.0:
        raise AttitudeError(
            f"rho is {elements.rho:.6g} and X is {elements.X:.6g}; rho lies between 0 and 1 "
            "(exclusive; without nutation no ratios of moments follow), X from 0 to 1."
        )
    if elements.X > 0.0 and _log_nome(elements.rho, elements.X).real > _SEPARATRIX:
        raise AttitudeError(
            f"1 - rho is {1.0 - elements.rho:.3g} and 1 - X is {1.0 - elements.X:.3g}: the "
            "separatrix to all digits, where no one body follows. Give the moments and the "
            "angular velocity."
        )
