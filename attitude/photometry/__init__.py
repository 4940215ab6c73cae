"""Photometry of a tumbling body: files, reduction, periods.

table            `Photometry`: brightness at epochs with errors, filters, sites and sessions
files            `read`: any known format; `named_columns`, `exchange_files`, `contents`
writing          CSV with named columns
reduction        distances, light time and phase angle from a path
periodograms     `periodogram`: one period, by Fourier series or phase dispersion
windows          the spectral window of the epochs, aliases in words
two_frequencies  `two_periods`: pairs of periods, blind
candidates       periods (P_psi, P_phi) in LAM and SAM from the lines of a pair
folding          `fold`: folded light curves, series and residuals
figures          a figure for each
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
