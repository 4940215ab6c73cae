"""Equally spaced epochs of any number, computed block by block.

If start or stop is a date, the steps are seconds of UTC (leap seconds count), so that 00:00 is
followed by 01:00; if both count from the epoch, they are seconds of TDB, as in
``motion.at(seconds)``.  The two differ by microseconds.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, pairs, quantity_text
from attitude.epochs import time_scales
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

    Pair = tuple[FloatArray, FloatArray]  # high and low parts, s

# A longer table is a mistake: a terabyte of text.
_MOST_ROWS = 10**10
_SHORTEST = Fraction(1, 10**9)
# Seconds since J2000 of the years 0001 to 9999.
_FIRST, _LAST = -63082281600.0, 252455529600.0
# The stop is included if a whole number of steps misses it by no more, in steps.
_ROUNDING = Fraction(1, 10**9)


@dataclass(frozen=True)
class Grid:
    """Epochs start + k step, for k from 0 to count - 1.

    Attributes
    ----------
    epoch : Instant
        From which the seconds of `block` count.
    start : Instant
    step : Fraction
        Seconds, negative for times that run backwards.
    count : int
    uniform_in : str
        "utc" or "tdb": the time scale of the steps.
    """

    epoch: epochs.Instant
    start: epochs.Instant
    step: Fraction
    count: int
    uniform_in: str

    def block(self, first: int, count: int) -> Pair:
        """TDB seconds since the epoch of at most `count` epochs, from number `first` on.

        Returns
        -------
        hi, lo : (N,) arrays
            The seconds are hi + lo.
        """
        number = np.arange(first, min(first + count, self.count), dtype=np.float64)
        elapsed = _times(number, self.step)
        offset = pairs.add(
            (self.start.seconds, self.start.low), -self.epoch.seconds, -self.epoch.low
        )
        seconds = pairs.add(offset, *elapsed)
        if self.uniform_in == "tdb":
            return seconds
        tt0 = _tt(self.start)
        then = time_scales.difference_at(*pairs.add(tt0, *elapsed))
        change = then - time_scales.difference_at(np.float64(tt0[0]), np.float64(tt0[1]))
        # The difference from an array and from one number may differ by 5e-15 s.
        return pairs.add(seconds, np.where(number == 0.0, 0.0, change))

    @property
    def digits(self) -> int:
        """Decimals of a second that the dates in UTC need: 0, 3, 6 or 9."""
        if self.uniform_in == "tdb" and self.count > 1:
            return 9
        step = self.step if self.count > 1 else Fraction(0)
        decimals = re.search(r"\.(\d+)$", self.start.utc_iso)
        fraction = Fraction("0." + decimals.group(1)) if decimals else Fraction(0)
        for digits in (0, 3, 6):
            if (fraction * 10**digits).denominator == (step * 10**digits).denominator == 1:
                return digits
        return 9


def grid(epoch: epochs.Instant, start: str, stop: str, step: str) -> Grid:
    """The Grid of the texts of --start, --stop and --step.

    Parameters
    ----------
    epoch : Instant
    start, stop : str
        Dates, or times after the epoch: seconds ("3600") or with a unit ("3 d").
    step : str
        Seconds or with a unit; negative if stop lies before start.

    Raises
    ------
    AttitudeError
        For texts that are no times, epochs outside of the years 0001 to 9999, a step that is zero,
        below 1e-9 s or of the wrong sign, and more than 10^10 epochs.
    """
    pace = duration(step, "--step")
    if pace == 0:
        raise AttitudeError('--step is zero; give the time between two rows, like "10 s" or "1 h".')
    if abs(pace) < _SHORTEST:
        raise AttitudeError(
            f"--step is {step}; give at least 1e-9 s, the shortest step that dates resolve."
        )
    first, last = _moment(start, "--start"), _moment(stop, "--stop")
    dated = isinstance(first, epochs.Instant) or isinstance(last, epochs.Instant)
    uniform_in = "utc" if dated else "tdb"
    begin = _instant(first, epoch, uniform_in, "--start", start)
    end = _instant(last, epoch, uniform_in, "--stop", stop)
    if isinstance(first, Fraction) and isinstance(last, Fraction):
        span = last - first
    else:
        span = _exact(_tt(end)) - _exact(_tt(begin))
    if span * pace < 0 and abs(span) > _ROUNDING:
        where = "before" if span < 0 else "after"
        raise AttitudeError(
            f"--stop {stop} lies {where} --start {start}, but --step is {step}; exchange the two, "
            "or change the sign of the step."
        )
    count = math.floor(span / pace + _ROUNDING) + 1
    if count > _MOST_ROWS:
        raise AttitudeError(
            f"--step {step} makes {count} rows, more than {_MOST_ROWS}; take a longer step."
        )
    return Grid(epoch, begin, pace, max(count, 1), uniform_in)


def one(epoch: epochs.Instant, text: str, name: str) -> epochs.Instant:
    """The Instant of one text, as --start of `grid`; the name begins error messages."""
    return _instant(_moment(text, name), epoch, "tdb", name, text)


def duration(text: str, name: str) -> Fraction:
    """Seconds as an exact fraction, of text such as "10", "0.1 s" or "3 d".

    Raises
    ------
    AttitudeError
        For other text; the message begins with the name.
    """
    numbers, unit = quantity_text.numbers_and_unit(text, name)
    if len(numbers) != 1:
        raise AttitudeError(f'{name} is {text!r}; give one time, like "10 s" or "3 d".')
    length = Fraction(numbers[0])
    factor = quantity_text.common_factor(unit, "s")
    if factor is not None:
        return length * Fraction(repr(factor))
    if unit:
        from astropy import units

        try:
            # The shortest decimal of the factor: 0.001 s for a ms, not the double nearest to it.
            length *= Fraction(repr(float(quantity_text.unit_of(unit, name).to("s"))))
        except units.UnitConversionError:
            raise AttitudeError(
                f'{name} is {text!r}; give a time, like "10 s", "1 h" or "3 d".'
            ) from None
    return length


def _moment(text: str, name: str) -> epochs.Instant | Fraction:
    """A date as Instant, a time after the epoch as Fraction."""
    if re.match(r"\s*\d{4}-\d", text):
        return epochs.instant(text, name)
    try:
        return duration(text, name)
    except AttitudeError as err:
        if re.match(r"\s*[-+.]?\d", text):
            raise
        raise AttitudeError(
            f'{name} is {text!r}; give a date in UTC like "2026-01-01T00:00:00", or a time after '
            'the epoch like 3600 or "3 d".'
        ) from err


def _instant(
    moment: epochs.Instant | Fraction, epoch: epochs.Instant, scale: str, name: str, text: str
) -> epochs.Instant:
    if isinstance(moment, epochs.Instant):
        found = moment
    else:
        # Checked before it becomes a float: 10**400 has none.
        if abs(moment) > Fraction(_LAST - _FIRST):
            raise _out_of_calendar(name, text)
        hi = float(moment)
        lo = float(moment - Fraction(hi))
        if scale == "tdb":
            found = epoch.after(hi, lo)
        elif moment == 0:
            found = epoch
        else:
            tt = pairs.add(_tt(epoch), hi, lo)
            tdb = time_scales.tdb_from("tt", np.float64(tt[0]), np.float64(tt[1]))
            found = epochs.Instant(float(tdb[0]), float(tdb[1]))
    if not _FIRST <= found.seconds < _LAST:
        raise _out_of_calendar(name, text)
    return found


def _out_of_calendar(name: str, text: str) -> AttitudeError:
    return AttitudeError(
        f"{name} is {text}, which leads out of the years 0001 to 9999; give an epoch within them."
    )


def _tt(instant: epochs.Instant) -> tuple[float, float]:
    """TT seconds since J2000."""
    hi, lo = time_scales.tt_from_tdb(np.float64(instant.seconds), np.float64(instant.low))
    return float(hi), float(lo)


def _exact(pair: tuple[float, float]) -> Fraction:
    return Fraction(float(pair[0])) + Fraction(float(pair[1]))


def _times(number: FloatArray, step: Fraction) -> Pair:
    """The products of whole numbers below 2**34 and a fraction, as a pair without loss."""
    # 19 bits of the step at a time, so that each product with a number of 34 bits is exact.
    hi, lo, rest = 0.0 * number, 0.0 * number, step
    while rest:
        part = _leading(rest)
        rest -= Fraction(part)
        hi, lo = pairs.add((hi, lo), number * part)
        if abs(rest) * 2**140 < abs(step):
            break
    return hi, lo


def _leading(fraction: Fraction) -> float:
    """The leading 19 bits."""
    mantissa, exponent = math.frexp(float(fraction))
    return math.ldexp(math.trunc(math.ldexp(mantissa, 19)), exponent - 19)
