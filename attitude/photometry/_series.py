"""Fourier series in the two frequencies of a tumbler, fitted to light curves by least squares.

Source: Pravec et al., Icarus 173, 108 (2005), eq. 11.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.quantity_text import counted
from attitude.epochs import _inputs
from attitude.epochs._instants import J2000, Instant
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.photometry import _samples, _spectrum
from attitude.photometry._samples import Line, frequencies_of, known_orders, line_at
from attitude.photometry._spectrum import line_numbers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epochs, FloatArray, IntArray, Real, Reals
    from attitude.photometry._curve import LightCurve


@dataclass(frozen=True, eq=False, repr=False)
class SeriesFit(Immutable):
    """A series in two frequencies, fitted by least squares.

    Attributes
    ----------
    P_psi, P_phi : float
        s.
    order : (int, int)
        Of psi and of phi.
    offsets : (C,) array
        The constant term of each curve.
    cosines, sines : (K,) arrays
        Coefficients of cos and sin of 2 pi (i / P_phi + j / P_psi) (t - start).
    numbers : (K, 2) array of int
        i and j of each of them.
    start : float
        s; the middle of the data.
    residuals : (N,) array
        Data minus model, in the order of the data.
    rms : float
        sqrt(sum w r^2 / (N - parameters)), in the unit of the data (of the errors, if given).
    epoch : Instant or None
        From which seconds count, where epochs were given as dates or Time objects.
    rank : int
        Of the equations: below `parameters` the span does not resolve some lines, and the
        solution of least norm is given.
    parameters : int
    """

    P_psi: float
    P_phi: float
    order: tuple[int, int]
    offsets: FloatArray
    cosines: FloatArray
    sines: FloatArray
    numbers: IntArray
    start: float
    residuals: FloatArray
    rms: float
    rank: int
    parameters: int
    epoch: Instant | None = None

    def __call__(self, t: Epochs, curve: ArrayLike = 0) -> FloatArray:
        """The model at epochs t, with the constant term of a curve (a number, or one per t)."""
        seconds = _inputs.seconds_since(self.epoch or J2000, t).rounded
        curves = np.asarray(curve)
        if not (
            curves.dtype.kind in "iu"
            and curves.shape in ((), seconds.shape)
            and np.all((curves >= 0) & (curves < len(self.offsets)))
        ):
            raise AttitudeError(
                f"curve is {validation.shown(curves)}; give whole numbers from 0 to "
                f"{len(self.offsets) - 1}, one for all epochs or one for each."
            )
        frequencies = np.array([1.0 / self.P_phi, 1.0 / self.P_psi])
        angles = _spectrum.line_angles(seconds.reshape(-1), self.start, frequencies, self.numbers)
        wave = np.cos(angles) @ self.cosines + np.sin(angles) @ self.sines
        return wave.reshape(seconds.shape) + self.offsets[curves]

    @property
    def amplitudes(self) -> FloatArray:
        """(K,) half of the peak-to-peak value of each line, in the unit of the data."""
        return np.hypot(self.cosines, self.sines)

    def strongest(self, count: int | None = None) -> list[tuple[Line, float]]:
        """The `count` strongest lines (all by default) with their amplitudes, in that order."""
        amplitudes = self.amplitudes
        lines_of = []
        for k in np.argsort(-amplitudes, kind="stable")[:count]:
            i, j = (int(n) for n in self.numbers[k])
            line = line_at(i, j, abs(i / self.P_phi + j / self.P_psi))
            lines_of.append((line, float(amplitudes[k])))
        return lines_of

    def __repr__(self) -> str:
        return (
            f"<SeriesFit of order {self.order}: P_psi {self.P_psi:.9g} s, P_phi {self.P_phi:.9g} "
            f"s, rms {self.rms:.3g}>"
        )


def fit_series(
    t: Epochs | LightCurve,
    values: Reals | None = None,
    P_psi: Real | None = None,
    P_phi: Real | None = None,
    *,
    order: int | Sequence[int] = 2,
    errors: Reals | None = None,
    curve: ArrayLike | None = None,
) -> SeriesFit:
    """Fit a two-dimensional Fourier series to a light curve.

    Parameters
    ----------
    t : (N,) epochs, or LightCurve
        Time objects, dates, time Quantities or plain seconds, in any order; or a `LightCurve`,
        without values, errors and curve: ``fit_series(data, P_psi="5.4 d", P_phi="7.4 d")``; two
        terms of the phase angle are fitted too, as in `periods`, where it changes.
    values : (N,) array_like
        Magnitudes or intensities; Quantities in any unit.
    P_psi, P_phi : float, Quantity or text
        s; in either convention.
    order : int or pair (order of psi, order of phi)
        2 m (m + 1) lines for an order m.
    errors : (N,) array_like, optional
        One standard deviation of each value, in the unit of the values.
    curve : (N,) array_like of int, optional
        Number of the curve to which each value belongs, from 0: each has its own constant term.

    Returns
    -------
    SeriesFit

    Raises
    ------
    AttitudeError
        For fewer values than unknowns, and shapes that do not fit.

    Warns
    -----
    AttitudeWarning
        If the values do not determine all parameters (`SeriesFit.rank`).

    >>> t = np.linspace(0, 1000, 400)
    >>> found = fit_series(t, 5 + 2 * np.cos(2 * np.pi * (1 / 17 - 1 / 90) * t), 90, 17)
    >>> line, amplitude = found.strongest(1)[0]
    >>> (line.i, line.j), round(amplitude, 9)
    ((1, -1), 2.0)
    """
    data = _samples.of(t, values, errors, curve)
    orders = known_orders(order)
    if P_psi is None or P_phi is None:
        missing = "P_psi" if P_psi is None else "P_phi"
        raise AttitudeError(f"{missing} is missing; give P_psi= and P_phi=, in s or with units.")
    psi, phi = frequencies_of(P_psi, P_phi)
    numbers = np.array(line_numbers(orders))
    count, first = len(numbers), data.linear
    unknowns = first + 2 * count
    if len(data.t) < unknowns:
        raise _spectrum.too_few(data, counted(unknowns, "unknown"))
    fit = _spectrum.series_at(data, np.array([phi, psi]), numbers, data.weights)
    if fit.rank < unknowns:
        warnings.warn(
            f"the values determine {fit.rank} of the {unknowns} parameters: within "
            f"{np.ptp(data.t):.4g} s some lines are not separated, and their amplitudes are those "
            "of least norm. Give a longer span, more epochs, or a lower order.",
            AttitudeWarning,
            stacklevel=2,
        )
    return SeriesFit(
        P_psi=1.0 / psi,
        P_phi=1.0 / phi,
        order=orders,
        offsets=frozen(fit.solution[: data.curves]),
        cosines=frozen(fit.solution[first : first + count]),
        sines=frozen(fit.solution[first + count :]),
        numbers=frozen(numbers),
        start=data.middle,
        residuals=frozen(fit.residuals / data.weights),
        rms=float(np.sqrt(fit.chi_squared / max(1, len(data.t) - fit.rank))),
        rank=fit.rank,
        parameters=unknowns,
        epoch=data.epoch,
    )
