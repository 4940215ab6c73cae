"""Photometry of a tumbling body: files, reduction, periods.

How to use it::

    from attitude import paths, photometry

    curve = photometry.LightCurve.read("curve.csv")  # or ALCDEF, ADES, MPC, DAMIT, ECSV
    curve = curve.reduced(paths.mpc_orbit(line), g=0.15)  # light time, distances, phase function
    found = photometry.periods(curve, count=2, min_period="2 h", max_period="40 h")
    photometry.fold(curve, found[0].periods, order=2).plot("folded.png")

_curve         `LightCurve`: brightness at epochs with errors, sessions, sites and geometry; the
               reduction to 1 au; CSV with named columns
_files         photometry in files of any known format; `BadRow`
_periods       `periods`: one period or two, blind, and their result `Periods`
_periodogram   the scan over one frequency; the spectral window of the epochs, aliases in words
_lattices      lattices of lines: candidates (P_psi, P_phi) of two frequencies, relations in words
_folding       `fold`: folded light curves, series and residuals
_samples       light curves as numbers, from any input; lines in the spectrum of a tumbler
_series        `fit_series`: Fourier series at the two periods of a tumbler
_spectrum      sums of exponentials, and the search over pairs of frequencies, compiled
_figures       a figure for each
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.photometry._curve import LightCurve, phase_angle
from attitude.photometry._files import BadRow
from attitude.photometry._folding import Folded, fold
from attitude.photometry._lattices import PeriodCandidate
from attitude.photometry._periods import Peak, Periods, periodogram, periods, two_periods
from attitude.photometry._samples import Line, lines
from attitude.photometry._series import SeriesFit, fit_series

# Earlier names of the class, of its reader, and of the results of `periods`.
Photometry = LightCurve
read = LightCurve.read
Periodogram = TwoPeriods = Periods
PeriodPair = Peak

__all__ = [
    "BadRow",
    "Folded",
    "LightCurve",
    "Line",
    "Peak",
    "PeriodCandidate",
    "PeriodPair",
    "Periodogram",
    "Periods",
    "Photometry",
    "SeriesFit",
    "TwoPeriods",
    "fit_series",
    "fold",
    "lines",
    "periodogram",
    "periods",
    "phase_angle",
    "read",
    "two_periods",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
