"""Certificates: proved upper bounds of the errors of attitudes at epochs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from decimal import Decimal
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.proof import _exact
from attitude.proof._exact import Number, Solution, Undecided

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray, IntArray

# A solution at the present precision, which may raise Undecided.
Build = Callable[[], Solution]

# Bits at first; the precision is doubled where it does not suffice.
_FIRST = 128
# Bits at most.
_MOST = 1 << 16
# Largest radius of an error, rad (of an angular velocity, relative to its magnitude).
_RADIUS = 1e-18

ASSUMED: tuple[str, ...] = (
    "doubles are those of IEEE 754 (binary64)",
    "the balls of FLINT (Arb) enclose what they stand for",
    "the solution of docs/derivation.md, which is proved on paper",
)


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Balls have so many bits inside."""
    context = _exact.flint().ctx
    before = context.prec
    context.prec = bits
    try:
        yield
    finally:
        context.prec = before


@dataclass(frozen=True, eq=False, repr=False)
class Certificate:
    """Proved upper bounds of the errors of attitudes.

    Attributes
    ----------
    seconds, low : (...) arrays
        seconds + low are TDB seconds since the epoch of the spin.
    error : (...) array
        rad; not less than the rotation angle between the attitude and the exact one, and above it
        by less than 1e-18.
    same_sign : (...) array of bool
        Whether the quaternion has the sign of the continuous motion, by proof.
    rate_error : (...) array or None
        rad/s; not less than the magnitude of the error of the angular velocity.
    bits : (...) array
        The precision that was needed.
    assumed : tuple of str
        What the proof rests on.
    """

    seconds: FloatArray
    low: FloatArray
    error: FloatArray
    same_sign: BoolArray
    rate_error: FloatArray | None
    bits: IntArray
    _builds: Sequence[tuple[Build, Number]] = field(default=())
    assumed: tuple[str, ...] = ASSUMED

    def __repr__(self) -> str:
        count = self.error.size
        worst = f", errors of at most {self.error.max():.3g} rad" if count else ""
        return (
            f"<Certificate: {count} attitude{'s' * (count != 1)}{worst}; assumed: "
            f"{'; '.join(self.assumed)}>"
        )

    def reshaped(self, shape: tuple[int, ...]) -> Certificate:
        """The certificate with arrays of another shape."""
        arrays = ("seconds", "low", "error", "same_sign", "bits")
        changes: dict[str, Any] = {name: getattr(self, name).reshape(shape) for name in arrays}
        if self.rate_error is not None:
            changes["rate_error"] = self.rate_error.reshape(shape)
        return replace(self, **changes)

    def exact(self, digits: int = 40) -> Any:
        """The exact unit quaternions, (..., 4) array of `decimal.Decimal`, scalar first.

        Parameters
        ----------
        digits : int
            Decimals behind the point; each component is right to one unit of the last one.

        Raises
        ------
        AttitudeError
            For a number of digits that is not from 1 to 10,000.
        """
        digits = validation.count(digits, "digits", most=10_000)
        rows = [_digits_of(build, t, digits) for build, t in self._builds]
        return np.array(rows, dtype=object).reshape(*self.error.shape, 4)


def _digits_of(build, t, digits):
    """The components of the exact quaternion at t as decimals."""
    bits = max(_FIRST, int(3.33 * digits) + 64)
    limit = _exact.flint().arb(10) ** -(digits + 1)
    while bits <= max(_MOST, 16 * digits):
        with precision(bits):
            try:
                wxyz = build().at(t)
            except Undecided:
                wxyz = []
            if wxyz and all(x.is_finite() and x.rad() < limit for x in wxyz):
                return [_decimal(x, digits) for x in wxyz]
        bits *= 2
    raise _not_enclosed()


def _decimal(x, digits):
    scaled = (x.mid() * _exact.flint().arb(10) ** digits + 0.5).floor().unique_fmpz()
    if scaled is None:  # half a unit away from two numbers: either is right to one unit
        scaled = (x.mid() * _exact.flint().arb(10) ** digits).mid().floor().unique_fmpz()
    return Decimal(f"{int(scaled)}e-{digits}")  # exact, unlike arithmetic of decimals


def _not_enclosed():
    return AttitudeError(
        f"the exact attitude is not enclosed at {_MOST} bits: a decision of the solution is closer "
        "than that (docs/proof.md); no bound is given."
    )


def certified(
    motions: Sequence[tuple[Build, Sequence[int]]],
    times: Sequence[Number],
    seconds: tuple[FloatArray, FloatArray],
    wxyz: FloatArray,
    rates: FloatArray | None = None,
) -> Certificate:
    """The certificate of attitudes (T, 4), of any length, and of angular velocities (T, 3).

    motions: functions that make solutions, and which of the epochs are theirs.
    times: fractions, seconds since t = 0 of the solution of each epoch.
    seconds: as the certificate shows them, two arrays (...).
    AttitudeError if an attitude is not finite, or not enclosed at 65,536 bits.
    """
    count = len(times)
    if not np.all(np.isfinite(wxyz)) or np.any(np.all(wxyz == 0.0, axis=-1)):
        raise AttitudeError("an attitude is not finite or zero; it cannot be certified.")
    error, bits = np.full(count, np.nan), np.zeros(count, dtype=np.int64)
    same_sign = np.zeros(count, dtype=bool)
    rate_error = None if rates is None else np.full(count, np.nan)
    builds: list[Any] = [None] * count
    for build, indices in motions:
        pending = list(indices)
        for k in pending:
            builds[k] = build, times[k]
        digits = _FIRST
        while pending:
            if digits > _MOST:
                raise _not_enclosed()
            with precision(digits):
                later = []
                try:
                    solution: Solution | None = build()
                except Undecided:
                    solution = None
                for k in pending:
                    bounds = _bounds(
                        solution, times[k], wxyz[k], None if rates is None else rates[k]
                    )
                    if bounds is None:
                        later.append(k)
                        continue
                    error[k], same_sign[k], bits[k] = bounds[0], bounds[1], digits
                    if rate_error is not None:
                        rate_error[k] = bounds[2]
            pending, digits = later, 2 * digits
    return Certificate(*seconds, error, same_sign, rate_error, bits, tuple(builds))


def _bounds(solution, t, wxyz, rates):
    """Bound of the angle, whether the sign is right, bound of the rates; None for too few bits."""
    if solution is None:
        return None
    arb = _exact.flint().arb
    try:
        difference = solution.difference([arb(x) for x in wxyz.tolist()], t)
    except Undecided:
        return None
    angle = 2 * arb.atan2(_exact.norm(difference[1:]), abs(difference[0]))
    if not angle.is_finite() or not float(angle.rad()) < _RADIUS:
        return None
    rate_bound = math.nan
    if rates is not None:
        exact = solution.rates(solution.at(t))
        off = _exact.norm([arb(x) - y for x, y in zip(rates.tolist(), exact, strict=True)])
        speed = float(_exact.norm(exact).upper())
        if not off.is_finite() or not float(off.rad()) <= _RADIUS * speed:
            return None
        rate_bound = upper(off)
    return upper(angle), bool(difference[0] > 0), rate_bound


def upper(x: Number) -> float:
    """A double that is not less than the magnitude of a ball."""
    return math.nextafter(float(abs(x).upper()), math.inf)
