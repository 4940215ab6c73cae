"""Photometry of a tumbling body: files, reduction, periods.

_curve        `Photometry`: brightness at epochs with errors, filters, sites and sessions; reduction
              by a path; CSV with named columns
_files        `read`: any known format
_periodogram  `periodogram`: one period, by Fourier series or phase dispersion; aliases in words
_two_periods  `two_periods`: pairs of periods, blind; candidates (P_psi, P_phi) in LAM and SAM
_folding      `fold`: folded light curves, series and residuals
_samples      a light curve as numbers; `_series`, Fourier series in two frequencies
_spectrum     sums over uneven epochs, normal equations of pairs of frequencies, chance
_figures      a figure for each
"""

from attitude.photometry._curve import BadRow, Photometry, phase_angle
from attitude.photometry._files import read
from attitude.photometry._folding import Folded, fold
from attitude.photometry._periodogram import Peak, Periodogram, periodogram
from attitude.photometry._two_periods import PeriodCandidate, PeriodPair, TwoPeriods, two_periods

__all__ = [
    "BadRow",
    "Folded",
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
