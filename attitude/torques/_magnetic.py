"""Torques of a magnetic field: eddy currents, and a dipole; the fields of the Earth.

A field is sampled along the path of the body together with its rate of change over inertial axes,
which eddy currents feel too: without it the pole of a satellite moves wrongly by a third and more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude._solver import chebyshev
from attitude._solver.march_layout import BY_RATE
from attitude._support import pairs, validation
from attitude._support.arrays import Immutable, frozen, read_only
from attitude._support.constants import DAY_S
from attitude._textfiles.lines import packaged
from attitude.epochs._inputs import instant as instant_of
from attitude.errors import AttitudeError
from attitude.paths import _ground
from attitude.torques._torque import (
    Torque,
    matrix_of,
    path_of,
    positions,
    refuse_relative,
    span_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import Epoch, FloatArray, Reals
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.paths._path import Path
    from attitude.torques._torque import AnyPath

    FieldFunction: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
    AnyField: TypeAlias = "MagneticField | FieldFunction"

# mu_0 / 4 pi, T m/A: CODATA 2018, 1.25663706212e-6 / (4 pi)
_MU_0_OVER_4_PI = 1.00000000055e-7


# ---- Fields


class MagneticField(Immutable):
    """The base of magnetic fields.

    A new kind defines `at`.  `is_smooth` says that a field varies with the path alone and can be
    fitted by polynomials along it; others are differenced.  `turn` is the time in s in which it
    turns over inertial axes; infinite for one that does not.
    """

    is_smooth: bool = False
    turn: float = math.inf

    def at(
        self, instant: Instant, seconds: FloatArray, low: FloatArray, position: FloatArray
    ) -> FloatArray:
        """The field (K, 3) in T over ICRF axes.

        Parameters
        ----------
        instant : Instant
        seconds, low : (K,) float64 arrays
            The epochs are instant + seconds + low, TDB.
        position : (K, 3) array
            m from the centre of the Earth, ICRF axes.
        """
        raise NotImplementedError(f"{type(self).__name__} defines no at")

    def span(self, instant: Instant) -> tuple[float, float]:
        """First and last TDB seconds since an instant that the field covers."""
        return -math.inf, math.inf


class _FunctionField(MagneticField):
    """A field by a function of TDB seconds since the instant and positions."""

    function: FieldFunction

    def __init__(self, function: FieldFunction) -> None:
        self._set("function", function)

    def at(self, instant, seconds, low, position):
        values = np.asarray(self.function(seconds, position), dtype=np.float64)
        if values.shape != position.shape or not np.all(np.isfinite(values)):
            raise AttitudeError(
                f"field returned {validation.shown(values)} for {len(seconds)} epochs; it must "
                "return finite numbers (..., 3) in T over ICRF axes."
            )
        return values


@dataclass(frozen=True, eq=False, init=False)
class DipoleField(MagneticField):
    """The field of a dipole that is fixed over ICRF axes, in the centre of the path.

    Parameters
    ----------
    moment : (3,) array_like
        A m2 over ICRF axes; the Earth's is about 7.8e22 and points south.

    Notes
    -----
    mu_0 / (4 pi r^3) (3 u (u . m) - m), u = r/r: Jackson, Classical Electrodynamics, eq. 5.56.  The
    Earth's tilted dipole, which turns with it, is ``IGRF(degree=1)``.
    """

    moment: FloatArray
    is_smooth = True

    def __init__(self, moment: Reals) -> None:
        self._set("moment", frozen(validation.real(moment, "moment", shape=(3,), unit="A m2")))

    def at(
        self, instant: Instant, seconds: FloatArray, low: FloatArray, position: FloatArray
    ) -> FloatArray:
        """The field (K, 3) in T over ICRF axes; see `MagneticField.at`."""
        r = np.sqrt(np.sum(position * position, axis=-1, keepdims=True))
        u = position / r
        along = np.sum(u * self.moment, axis=-1, keepdims=True)
        return _MU_0_OVER_4_PI / r**3 * (3.0 * along * u - self.moment)


@dataclass(frozen=True, eq=False, init=False)
class IGRF(MagneticField):
    """The Earth's main field: International Geomagnetic Reference Field, 14th generation.

    Parameters
    ----------
    degree : int
        From 1, the tilted dipole, to 13.
    epoch : epoch, optional
        Of the coefficients, as a Spin takes it; by default each epoch has its own.  The field of
        one epoch turns with the Earth at all others, beyond those of the model too.

    Raises
    ------
    AttitudeError
        For another degree, an epoch before 1955 or after 2030; from `at`, for such epochs if no
        epoch is given.

    Notes
    -----
    Coefficients of IAGA V-MOD, doi.org/10.5281/zenodo.14012302 (November 2024), linear between
    epochs of five years; from 2025 on a prediction.  The Earth turns by the IERS table and, outside
    of it, by a model of UT1 (seconds in years, 1e-4 rad).  Cunningham's recursion, regular at the
    poles (Montenbruck & Gill, Satellite Orbits, eqs. 3.29 to 3.33).
    """

    degree: int
    epoch: Instant | None
    is_smooth = True
    turn = 2.0 * math.pi / _ground.RATE

    def __init__(self, degree: int = 13, epoch: Epoch | None = None) -> None:
        degree = validation.count(degree, "degree")
        if not 1 <= degree <= 13:
            raise AttitudeError(f"degree is {degree}; the model has the degrees 1 to 13.")
        self._set_all(degree=degree, epoch=None if epoch is None else instant_of(epoch))
        if self.epoch is not None:
            _coefficients_in(_years(self.epoch, np.zeros(1), np.zeros(1)))

    def at(
        self, instant: Instant, seconds: FloatArray, low: FloatArray, position: FloatArray
    ) -> FloatArray:
        """The field (K, 3) in T over ICRF axes; see `MagneticField.at`."""
        hi, lo = pairs.add((seconds, low), instant.seconds, instant.low)
        of = (instant, seconds, low) if self.epoch is None else (self.epoch, *np.zeros((2, 1)))
        numbers = _coefficients_in(_years(*of))
        # Earth-fixed axes over ICRF: (axis, component, K)
        axes = _ground.axes_to_celestial(hi, lo)
        fixed = np.einsum("ack,kc->ka", axes, position)
        return np.einsum("ack,ka->kc", axes, _gradient(fixed, numbers, self.degree))

    def span(self, instant: Instant) -> tuple[float, float]:
        """First and last TDB seconds since an instant that the coefficients cover."""
        if self.epoch is not None:
            return -math.inf, math.inf
        known, _ = _coefficients()
        days = (known[[0, -1]] - 2000.0) * 365.25 - 0.5
        first, last = days * DAY_S - (instant.seconds + instant.low)
        return float(first), float(last)


def _years(instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
    """Years (K,) of the calendar, to a day."""
    hi, lo = pairs.add((seconds, low), instant.seconds, instant.low)
    return 2000.0 + ((hi + lo) / DAY_S + 0.5) / 365.25


def _coefficients_in(years: FloatArray) -> FloatArray:
    """The coefficients (K, 14, 14) of years (K,), T."""
    known, table = _coefficients()
    # a day: the years are not more exact
    beyond = (years < known[0] - 0.003) | (years > known[-1] + 0.003)
    if np.any(beyond):
        raise AttitudeError(
            f"the epoch {float(years[beyond][0]):.1f} lies beyond the Earth's field; IGRF covers "
            f"{known[0]:.0f} to {known[-1]:.0f}. Give IGRF(epoch=...) to keep the coefficients of "
            "one epoch."
        )
    place = np.clip(np.searchsorted(known, years, side="right") - 1, 0, len(known) - 2)
    share = ((years - known[place]) / (known[place + 1] - known[place]))[:, None, None]
    return table[place] * (1.0 - share) + table[place + 1] * share


# m: reference radius of the model
_RADIUS = 6371200.0


@cache
def _coefficients() -> tuple[FloatArray, FloatArray]:
    """Years (N,), and coefficients of unnormalised functions (N, 14, 14), T.

    Entry [n, m] is that of the cosine, [m - 1, n] that of the sine of m times the longitude.
    """
    lines = [
        line.split()
        for line in packaged("reference/igrf14.txt").splitlines()
        if not line.startswith("#")
    ]
    years = np.array(lines[0], dtype=np.float64)
    table = np.zeros((len(years), 14, 14))
    for n, m, *numbers in lines[1:]:
        degree, order = int(n), abs(int(m))
        # from Schmidt's to unnormalised functions
        between = np.arange(degree - order + 1, degree + order + 1, dtype=np.float64)
        factor = np.sqrt((2.0 if order else 1.0) / np.prod(between))
        place = (order - 1, degree) if int(m) < 0 else (degree, order)
        table[:, *place] = 1e-9 * factor * np.array(numbers, dtype=np.float64)
    return frozen(years), frozen(table)


def _gradient(r: FloatArray, table: FloatArray, degree: int) -> FloatArray:
    """The field (K, 3) at Earth-fixed positions (K, 3), from coefficients (K, 14, 14)."""
    square = np.sum(r * r, axis=-1)
    x, y, z = (_RADIUS * r.T) / square
    shrunk = _RADIUS * _RADIUS / square
    top = degree + 2
    v = np.zeros((top, top, len(r)))
    w = np.zeros((top, top, len(r)))
    v[0, 0] = _RADIUS / np.sqrt(square)
    for m in range(top):
        if m:
            v[m, m] = (2 * m - 1) * (x * v[m - 1, m - 1] - y * w[m - 1, m - 1])
            w[m, m] = (2 * m - 1) * (x * w[m - 1, m - 1] + y * v[m - 1, m - 1])
        for n in range(m + 1, top):
            for function in (v, w):
                before = function[n - 2, m] if n > m + 1 else 0.0
                function[n, m] = (
                    (2 * n - 1) * z * function[n - 1, m] - (n + m - 1) * shrunk * before
                ) / (n - m)
    field = np.zeros((3, len(r)))
    for n in range(1, degree + 1):
        c = table[:, n, 0]
        field += np.array([c * v[n + 1, 1], c * w[n + 1, 1], (n + 1) * c * v[n + 1, 0]])
        for m in range(1, n + 1):
            c, s = table[:, n, m], table[:, m - 1, n]
            inner = (n - m + 2) * (n - m + 1)
            field[0] += 0.5 * (c * v[n + 1, m + 1] + s * w[n + 1, m + 1])
            field[0] -= 0.5 * inner * (c * v[n + 1, m - 1] + s * w[n + 1, m - 1])
            field[1] += 0.5 * (c * w[n + 1, m + 1] - s * v[n + 1, m + 1])
            field[1] += 0.5 * inner * (c * w[n + 1, m - 1] - s * v[n + 1, m - 1])
            field[2] += (n - m + 1) * (c * v[n + 1, m] + s * w[n + 1, m])
    return field.T


def field_of(field: AnyField) -> MagneticField:
    """The field itself, or that of a function."""
    if isinstance(field, MagneticField):
        return field
    validation.refuse_class(field, "field")
    if not callable(field):
        raise AttitudeError(
            f"field is {validation.shown(field)}; give IGRF(), DipoleField(moment), or a function "
            "of seconds (K,) since the epoch of the spin and positions (K, 3) in m that returns "
            "(K, 3) in T, both over ICRF axes."
        )
    return _FunctionField(field)


# ---- Samples along a path

# Coefficients of the polynomial of a piece.
_COUNT = 16
# rad, by which the direction of the path turns in a piece: the 13th harmonic of the field then has
# half a wave, and errs by 1e-11 of the field.
_TURN = 0.25
# A piece whose last two coefficients are larger than this share of its largest (near the pericenter
# of an eccentric orbit) is halved.
_TAIL = 1e-12
# At most so often; beyond, the field is differenced.
_HALVINGS = 7
# It is halved while each halving leaves less than this share of the last coefficients.
_SHRINKS = 0.125
# Pieces that are kept, and the step (s) of differences where nothing is fitted.
_MOST_PIECES = 100_000
# Answers at epochs far apart that are kept.
_MOST_ANSWERS = 256
_STEP = 0.5


class FieldOnPath:
    """A field and its rate of change over ICRF axes along a path from the centre of the Earth."""

    def __init__(self, field: MagneticField, path: Path) -> None:
        self._field, self._path = field, path
        # Instant -> width of a piece, and the pieces by number
        self._pieces: dict[tuple[float, float], tuple[float, chebyshev.KeptPieces]] = {}
        # Instant, epochs -> answer of `apart`
        self._apart = chebyshev.KeptPieces(_MOST_ANSWERS)

    def direct(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """The field (K, 3) in T, ICRF axes."""
        position = positions(self._path, instant, seconds, low, "path")
        if not np.all(np.any(position != 0.0, axis=-1)):
            raise AttitudeError("path passes through the centre; give a path at a distance.")
        return self._field.at(instant, seconds, low, position)

    def at(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """The field in T, and its rate of change in T/s, ICRF axes: (K, 6)."""
        if self._field.is_smooth and len(seconds):
            return self._fitted(instant, seconds, low)
        return self._differenced(instant, seconds, low)

    def apart(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """As `at`, by differences, and kept: means of two strengths ask for the same epochs."""
        key = instant.seconds, instant.low, seconds.tobytes(), low.tobytes()
        answer = self._apart.get(key)  # 1 microsecond faster than `of`
        if answer is None:
            [answer] = self._apart.of([key], lambda _: [self._differenced(instant, seconds, low)])
        return answer

    def _differenced(self, instant, seconds, low):
        """The rate by differences of fourth order; inwards at the ends of the path's span."""
        first, last = span_of(self._path, instant)
        middle = np.clip(seconds, first + 2.0 * _STEP, last - 2.0 * _STEP)
        sides = [self.direct(instant, middle + k * _STEP, low) for k in (-2, -1, 1, 2)]
        rate = (8.0 * (sides[2] - sides[1]) - (sides[3] - sides[0])) / (12.0 * _STEP)
        return np.concatenate([self.direct(instant, seconds, low), rate], axis=1)

    def _fitted(self, instant, seconds, low):
        key = instant.seconds, instant.low
        if key not in self._pieces:
            pieces = chebyshev.KeptPieces(_MOST_PIECES)
            self._pieces.setdefault(key, (self._width(instant), pieces))
        width, known = self._pieces[key]
        number = np.floor(seconds / width)
        wanted, piece = np.unique(number, return_inverse=True)
        first, last = span_of(self._path, instant)
        inside = (wanted * width >= first) & ((wanted + 1.0) * width <= last)
        fitted = known.of(wanted[inside].tolist(), lambda new: self._fit(instant, new, width))
        # each piece is so many equal parts, a row of coefficients each; none where nothing fits
        tables = [_NOTHING] * len(wanted)
        for k, table in zip(np.flatnonzero(inside), fitted, strict=True):
            tables[k] = table
        parts = np.array([len(table) for table in tables])
        out = np.empty((len(seconds), 6))
        outside = parts[piece] == 0
        if np.any(outside):
            out[outside] = self._differenced(instant, seconds[outside], low[outside])
        rows = np.flatnonzero(~outside)
        if rows.size:
            records = read_only(np.concatenate(tables))
            begins, count = (np.cumsum(parts) - parts)[piece[rows]], parts[piece[rows]]
            share = ((seconds[rows] - number[rows] * width) + low[rows]) / width * count
            whole = np.clip(np.floor(share), 0, count - 1)
            value, rate = np.empty((3, rows.size)), np.empty((3, rows.size))
            place, x = begins + whole.astype(np.int64), 2.0 * (share - whole) - 1.0
            chebyshev.values_and_rates(
                records, 0, _COUNT, place, x, np.array([width]), 1.0, value, rate
            )
            out[rows, :3], out[rows, 3:] = value.T, (rate * count).T
        return out

    def _fit(self, instant, numbers, width):
        """Coefficients (parts, 3 count) of numbered pieces; no part where nothing fits."""
        x = chebyshev.nodes(_COUNT)
        tables, before = dict.fromkeys(numbers, _NOTHING), np.full(len(numbers), np.inf)
        numbers = np.array(numbers)
        for halving in range(_HALVINGS + 1):
            parts = 1 << halving
            starts = numbers[:, None] + np.arange(parts) / parts
            at = (starts[..., None] + 0.5 / parts * (x + 1.0)) * width
            field = self.direct(instant, at.ravel(), np.zeros(at.size)).reshape(*at.shape, 3)
            table = np.moveaxis(chebyshev.coefficients(np.moveaxis(field, 2, 0)), 0, -1)
            size = np.abs(table).max(axis=(2, 3)) + 1e-300  # of no field too
            tail = np.max(np.abs(table[..., -2:]).max(axis=(2, 3)) / size, axis=1)
            fits = tail <= _TAIL
            for k, rows in zip(numbers[fits], table[fits], strict=True):
                tables[k] = np.ascontiguousarray(rows).reshape(parts, -1)
            # a kink, or rounding of the path, is not resolved by halving
            kept = ~fits & ~(tail > _SHRINKS * before)
            numbers, before = numbers[kept], tail[kept]
            if not numbers.size:
                break
        return tables.values()

    def _width(self, instant):
        """Seconds in which the direction of the path, or the Earth, turns by `_TURN`."""
        first, last = span_of(self._path, instant)
        t = np.clip([-10.0, 10.0], first, last)
        before, after = positions(self._path, instant, t, np.zeros(2), "path")
        size = np.sqrt(np.sum(before * before) * np.sum(after * after))
        turn = np.sqrt(np.sum(np.cross(before, after) ** 2)) / size
        slowest = DAY_S / (2.0 * np.pi) * _TURN
        if not t[1] > t[0] or not turn > 0.0:  # an epoch outside of the span: halvings find it
            return slowest
        return float(min(slowest, 0.5 * _TURN * float(t[1] - t[0]) / turn))


_NOTHING = np.empty((0, 3 * _COUNT))


# ---- Torques


class _InField(Torque):
    """The base of torques in a magnetic field along a path."""

    field: MagneticField
    path: Path

    def _set_field(self, field: Any, path: Any) -> None:
        self._set_all(field=field_of(field), path=path_of(path, "path"))

    @property
    def is_of_seconds(self) -> bool:
        """Whether path or field is a function of seconds since the epoch of the spin."""
        return super().is_of_seconds or isinstance(self.field, _FunctionField)

    def span(self, instant: Instant) -> tuple[float, float]:
        """The span of path and field; of the path alone where the field says what it lacks."""
        first, last = span_of(self.path, instant)
        begin, end = self.field.span(instant)
        if begin > 0.0 or end < 0.0:
            return first, last
        return max(first, begin), min(last, end)

    @cached_property
    def _on_path(self) -> FieldOnPath:
        return FieldOnPath(self.field, self.path)


@dataclass(frozen=True, eq=False, init=False)
class EddyCurrent(_InField):
    """The torque of the currents that a magnetic field induces in a conducting body.

    N = (M (w x B - B')) x B, where B' is the rate of change of the field over inertial axes along
    the path: rotation is braked, and the momentum turned towards that of the field.

    Parameters
    ----------
    tensor : (3, 3) array_like or float
        The magnetic tensor M in S m4 over the body axes, symmetric and not negative; a number means
        a multiple of the unit matrix.  A thin spherical shell has 2 pi/3 sigma R^4 e, a solid
        sphere 2 pi/15 sigma R^5 (conductivity sigma in S/m, radius R, thickness e in m).
    field : MagneticField, or function
        ``IGRF()``, `DipoleField`, or a function of seconds (K,) since the epoch of the spin and
        positions (K, 3), m, that returns (K, 3), T; both over ICRF axes.
    path : Path, or function
        The body's position from the centre of the Earth; see `GravityGradient`.

    Raises
    ------
    AttitudeError
        For a tensor that is not symmetric or has a negative eigenvalue, other shapes and units, a
        field or path of another type; from the motion, for epochs that field or path lack.

    Notes
    -----
    Ortiz Gomez & Walker, Adv. Space Res. 56, 1134 (2015): magnetic tensor.  Praly et al., Acta
    Astronaut. 76, 145 (2012).  The turning of the field: Efimov, Pritykin & Sidorenko,
    arXiv:1712.08596.
    """

    tensor: FloatArray
    field: MagneticField
    path: Path
    kind = BY_RATE
    _function = "eddy_current"
    columns = 6

    def __init__(self, tensor: Reals | float, field: AnyField, path: AnyPath) -> None:
        matrix = matrix_of(tensor, "tensor", "S m4")
        largest = np.max(np.abs(matrix))
        if np.max(np.abs(matrix - matrix.T)) > 1e-12 * largest:
            raise AttitudeError("tensor is not symmetric; give the magnetic tensor in S m4.")
        if np.linalg.eigvalsh(matrix).min() < -1e-12 * largest:
            raise AttitudeError(
                "tensor has a negative eigenvalue, and currents would add energy; give a matrix "
                "that is positive semidefinite."
            )
        self._set("tensor", frozen(0.5 * (matrix + matrix.T)))
        self._set_field(field, path)

    def parameters(self, body: Body) -> FloatArray:
        """The upper triangle of the tensor by rows (6,), S m4."""
        refuse_relative(body, "magnetic torques are in N m")
        return self.tensor[np.triu_indices(3)]

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """The field in T and its rate of change in T/s along the path, ICRF axes: (K, 6)."""
        return self._on_path.at(instant, seconds, low)

    def sample_apart(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """As `sample`, the rate by differences."""
        return self._on_path.apart(instant, seconds, low)


@dataclass(frozen=True, eq=False, init=False)
class MagneticDipole(_InField):
    """The torque m x B on a dipole that is fixed in the body: a residual dipole, a magnet.

    Parameters
    ----------
    moment : (3,) array_like
        A m2 over the body axes.
    field, path
        As for `EddyCurrent`.

    Raises
    ------
    AttitudeError
        As `EddyCurrent`.

    Notes
    -----
    Wertz (1978), Spacecraft Attitude Determination and Control, eq. 17-68.
    """

    moment: FloatArray
    field: MagneticField
    path: Path
    columns = 3
    _function = "magnetic_dipole"
    _slope = "magnetic_dipole_slope"

    def __init__(self, moment: Reals, field: AnyField, path: AnyPath) -> None:
        self._set("moment", frozen(validation.real(moment, "moment", shape=(3,), unit="A m2")))
        self._set_field(field, path)

    def parameters(self, body: Body) -> FloatArray:
        """The moment (3,), A m2 over the body axes."""
        refuse_relative(body, "magnetic torques are in N m")
        return np.array(self.moment)

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """The field (K, 3) in T along the path, ICRF axes."""
        return np.ascontiguousarray(self._on_path.at(instant, seconds, low)[:, :3])

    def sample_apart(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """As `sample`, without a fit along the path."""
        return self._on_path.direct(instant, seconds, low)
