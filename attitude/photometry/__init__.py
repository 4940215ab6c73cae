"""Photometry of a tumbling body: files, reduction, periods.

_curve         `LightCurve`: brightness at epochs with errors, sessions, sites and geometry; the
               reduction to 1 au; CSV with named columns
_files         photometry in files of any known format; `BadRow`
_periodogram   `periodogram`: one period; the spectral window of the epochs, aliases in words
_two_periods   `two_periods`: pairs of periods, blind; their candidates (P_psi, P_phi)
_folding       `fold`: folded light curves, series and residuals
_samples       light curves as numbers, from any input; lines in the spectrum of a tumbler
_series        Fourier series in the two frequencies of a tumbler
_spectrum      sums of exponentials, and the search over pairs of frequencies, compiled
_figures       a figure for each
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.photometry._curve import LightCurve, phase_angle
from attitude.photometry._files import BadRow
from attitude.photometry._folding import Folded, fold
from attitude.photometry._periodogram import Peak, Periodogram, periodogram
from attitude.photometry._two_periods import PeriodCandidate, PeriodPair, TwoPeriods, two_periods

__all__ = [
    "BadRow",
    "Folded",
    "LightCurve",
    "Peak",
    "PeriodCandidate",
    "PeriodPair",
    "Periodogram",
    "Photometry",
    "TwoPeriods",
    "fold",
    "periodogram",
    "phase_angle",
    "read",
    "two_periods",
]

# The earlier name of the class, and its reader.
Photometry = LightCurve
read = LightCurve.read

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
