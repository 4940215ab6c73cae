"""A motion as text: the output of `print(motion)` and of the command `describe`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from attitude import frames
from attitude._solver import covariance as covariances
from attitude._solver.regime import Mode
from attitude._support.constants import DAY_S
from attitude.errors import AttitudeError
from attitude.motions import _predictability
from attitude.motions._uncertainty import in_quadrature, possible_end

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray
    from attitude.motions._free_rotation import FreeRotation
    from attitude.motions._uncertainty import Uncertain

    Rows: TypeAlias = list[tuple[str, str]]


_DEGREE = math.degrees(1.0)
# Errors upward and downward that differ by less, relative to their sum, are printed as one.
_ASYMMETRY = 0.05
# Ratio of both from which the normal distribution of the state does not tell the error of a period.
_SKEWED = 3.0
# Error of the attitude, rad, up to which a motion is called predictable.
_TOLERANCE = 0.1
# 1 - m below which the times near the middle axis and of turning over are printed.
_NEAR_SEPARATRIX = 1e-2
_TUMBLING = (Mode.LONG_AXIS, Mode.SHORT_AXIS, Mode.SYMMETRIC)
# deg: a nutation below it is that of the rounding of the input.
_NO_NUTATION = 1e-13
# Modes within the rounding of the input, and their consequences.
_NEARLY = {
    Mode.SPHERICAL: "three equal moments",
    Mode.PRINCIPAL_AXIS: "rotation about a principal axis",
    Mode.SEPARATRIX: "the separatrix: where the body turns over is decided by the last digits",
    Mode.SYMMETRIC: "a symmetric body",
}


class _Errors:
    """Errors of one standard deviation as text, by name; empty text without a covariance."""

    def __init__(self, motion: FreeRotation) -> None:
        has_errors = motion.spin.covariance is not None
        self._found: dict[str, Uncertain] = motion.deviations() if has_errors else {}

    def of(self, name: str, factor: float = 1.0) -> str:
        """The error in units of 1 / factor: " +- 0.12", or " +0.1 -0.2" if the two differ."""
        if name not in self._found:
            return ""
        _, minus, plus = (factor * distance for distance in self._found[name])
        if not 0.0 < plus + minus < math.inf:
            return ""
        if abs(plus - minus) <= _ASYMMETRY * (plus + minus):
            return f" +- {0.5 * (plus + minus):.2g}"
        return f" +{plus:.2g} -{minus:.2g}"

    def is_skewed(self, name: str) -> bool:
        """Whether both errors differ so much that the number is not linear in the state."""
        _, minus, plus = self._found.get(name, (0.0, 0.0, 0.0))
        return max(plus, minus) > _SKEWED * min(plus, minus)

    def of_period(self, name: str, seconds: float) -> str:
        """The error of a period in the last unit of its text."""
        size, unit = _period_units(seconds)[-1]
        text = self.of(name, size / seconds) if math.isfinite(seconds) else ""
        return f"{text} {unit}" if text else ""


def description(motion: FreeRotation, *, predictable: bool = False) -> str:
    """The properties of a motion as text of several lines."""
    phrase, errors = motion.mode.phrase, _Errors(motion)
    rows = [("epoch", f"{motion.spin.epoch.utc_iso} UTC"), ("body", _body(motion))]
    rows += _rates(motion, errors)
    rows += _momentum(motion, errors)
    if motion.mode in (*_TUMBLING, Mode.SEPARATRIX):
        rows.append(("1 - 2 E I2 / L^2", _separatrix(motion, errors)))
    if motion.spin.covariance is not None:
        rows += _of_errors(motion, errors, predictable)
    rows += [("within rounding", _NEARLY[mode]) for mode in _near(motion)]
    width = max(len(label) for label, _ in rows)
    lines = [f"  {label:<{width}}  {value}" for label, value in rows]
    return "\n".join([phrase[0].upper() + phrase[1:], *lines])


def _body(motion: FreeRotation) -> str:
    body, covariance = motion.body, motion.spin.covariance
    unit = "(relative)" if body.relative else "kg m2"
    sigma = np.zeros(3) if covariance is None else np.sqrt(np.diag(covariance)[6:])
    texts = [
        f"{moment:.9g}" + (f" +- {error:.2g}" if error > 0.0 else "")
        for moment, error in zip(body.moments, sigma, strict=True)
    ]
    return f"principal moments {', '.join(texts)} {unit}"


def _of_errors(motion: FreeRotation, errors: _Errors, predictable: bool) -> Rows:
    """What the errors of the spin mean for the motion."""
    covariance = motion.spin.covariance
    assert covariance is not None  # as the caller has found
    x, y, z = np.degrees(np.sqrt(np.diag(covariance)[:3]))
    frame = motion.spin.frame
    frame = "the ecliptic of J2000" if frame == "ecliptic" else frame.upper()
    rows = [
        ("errors", "+- is one standard deviation"),
        ("  attitude", f"{x:.3g}, {y:.3g}, {z:.3g} deg about the axes of {frame}"),
    ]
    if math.isfinite(_predictability.flip_within_errors(motion)):
        rows.append(("  separatrix", "within the errors: the mode is uncertain"))
    elif motion.mode in _TUMBLING and any(map(errors.is_skewed, ("period_psi", "period_phi"))):
        rows.append(("  periods", "not linear in rates and moments, so that + and - differ"))
    if predictable and np.all(motion.body.moments > 0.0):
        seconds = motion.predictable_time(tolerance=_TOLERANCE)
        when = "always" if math.isinf(seconds) else f"for {period(seconds)}"
        limit = f"{math.degrees(_TOLERANCE):.3g} deg"
        rows.append(("  predictable", f"{when}, to {limit} of attitude"))
    return rows


def _rates(motion: FreeRotation, errors: _Errors) -> Rows:
    rate = math.degrees(math.hypot(*motion.spin.angular_velocity))
    if motion.mode is Mode.AT_REST:
        return []
    text = f"{rate:.9g}{errors.of('spin_rate', _DEGREE)} deg/s"
    if rate < 0.1:
        text += f" = {rate * DAY_S:.9g}{errors.of('spin_rate', _DEGREE * DAY_S)} deg/d"
    rows = [("angular velocity", f"{text} at the epoch")]
    if motion.mode in (Mode.SPHERICAL, Mode.PRINCIPAL_AXIS):
        rows.append(("period", period(360.0 / rate) + errors.of_period("period", 360.0 / rate)))
        if _about_middle(motion):
            rows.append(("stability", "about the middle axis: any disturbance turns the body over"))
        return rows
    if motion.mode is Mode.SEPARATRIX:
        return [*rows, ("period psi", period(motion.period_psi))]
    return [*rows, *_periods(motion, errors), *_ranges(motion, errors)]


def _periods(motion: FreeRotation, errors: _Errors) -> Rows:
    axis = motion.circulates_about
    other = "short" if axis == "long" else "long"
    name = "axis of symmetry" if motion.mode is Mode.SYMMETRIC else f"{axis} axis"
    psi = period(motion.period_psi) + errors.of_period("period_psi", motion.period_psi)
    phi = period(motion.period_phi) + errors.of_period("period_phi", motion.period_phi)
    rows = [("period phi", f"{phi}: {name} about the momentum")]
    # Of equal moments, about one of their axes, psi is the slow turn by the last digits of both.
    if not {Mode.PRINCIPAL_AXIS, Mode.SYMMETRIC} <= {*motion.within_rounding}:
        rows.insert(0, ("period psi", f"{psi}: rotation about the {name}"))
    if motion.mode is not Mode.SYMMETRIC:
        letter = other[0].upper()
        seconds = float(motion.regime.P_phi(letter))
        text = period(seconds) + errors.of_period(f"P_phi_{letter}", seconds)
        rows.append(("", f"{text}: {other} axis, convention {letter}"))
    return rows


def _ranges(motion: FreeRotation, errors: _Errors) -> Rows:
    regime, axis = motion.regime, motion.circulates_about
    low, high = np.degrees(regime.nutation("L" if axis == "long" else "S"))
    least = f"{low:.6g}{errors.of('nutation_least', _DEGREE)}"
    if high < _NO_NUTATION and not errors.of("nutation_greatest"):
        angle = f"none within rounding between {axis} axis and momentum"
    elif motion.mode is Mode.SYMMETRIC:
        angle = f"{least} deg between axis of symmetry and momentum"
    else:
        greatest = f"{high:.6g}{errors.of('nutation_greatest', _DEGREE)}"
        angle = f"{least} to {greatest} deg between {axis} axis and momentum"
    slow, fast = (float(bound) for bound in regime.spin_rate_range)
    rates = [
        _rate(math.degrees(rate), errors, f"spin_rate_{name}")
        for rate, name in (
            (slow, "least"),
            (fast, "greatest"),
            (float(regime.mean_spin_rate), "mean"),
        )
    ]
    ratio = f"{float(regime.energy_ratio):.9g}{errors.of('energy_ratio')}"
    share = f"{float(regime.one_minus_m):.6g}{errors.of('one_minus_m')}"
    rows = [
        ("nutation", angle),
        ("spin rate", "{} to {}, {} in the mean".format(*rates)),
        ("2 E C / L^2", f"{ratio} (E/E0)"),
        ("1 - m", f"{share} (0 on the separatrix)"),
    ]
    if motion.mode is not Mode.SYMMETRIC and float(regime.one_minus_m) < _NEAR_SEPARATRIX:
        flip, dwell = period(float(regime.flip_time)), period(float(regime.dwell_time))
        rows.append(("turning over", f"takes {flip}; near the middle axis for {dwell} in between"))
    return rows


def _rate(degrees: float, errors: _Errors, name: str) -> str:
    """A rate in deg/s, or in deg/d if it is below 0.1 deg/s, with the error of a name."""
    factor, unit = (1.0, "deg/s") if degrees >= 0.1 else (DAY_S, "deg/d")
    return f"{degrees * factor:.6g}{errors.of(name, _DEGREE * factor)} {unit}"


def period(seconds: float) -> str:
    """A period in seconds, and in hours and days if it is at least 0.1 of them.

    >>> period(86400.0), period(60.0)
    ('86400 s = 24 h = 1 d', '60 s')
    """
    if math.isinf(seconds):
        return "infinite"
    return " = ".join(f"{size:.9g} {unit}" for size, unit in _period_units(seconds))


def _period_units(seconds: float) -> list[tuple[float, str]]:
    """A period in seconds, and in hours and days if it is at least 0.1 of them."""
    units = [(seconds, "s"), (seconds / 3600.0, "h"), (seconds / DAY_S, "d")]
    return [(size, unit) for size, unit in units if unit == "s" or size >= 0.1]


def _about_middle(motion: FreeRotation) -> bool:
    """Whether a uniform rotation is about the middle axis."""
    rates = motion.body.rates_about_principal_axes(motion.spin.angular_velocity)[:, 0]
    moment = motion.body.moments[np.argmax(np.abs(rates))]
    return bool(motion.body.moments.min() < moment < motion.body.moments.max())


def _near(motion: FreeRotation) -> list[Mode]:
    """The modes within rounding that the mode of the motion does not imply."""
    implied: dict[Mode, tuple[Mode, ...]] = {
        Mode.SPHERICAL: (Mode.SYMMETRIC, Mode.SEPARATRIX),
        Mode.PRINCIPAL_AXIS: (Mode.SEPARATRIX,),
    }
    return [mode for mode in motion.within_rounding if mode not in implied.get(motion.mode, ())]


def _momentum(motion: FreeRotation, errors: _Errors) -> Rows:
    relative = motion.body.relative
    momentum = motion.momentum
    largest = np.max(np.abs(momentum))
    if largest == 0.0:
        return []
    size = largest * np.linalg.norm(momentum / largest)
    ecliptic = frames.matrix_to_icrf("ecliptic").T @ momentum
    unit = "rad/s times the unit of the moments" if relative else "kg m2/s"
    unit_of_energy = "rad2/s2 times the unit of the moments" if relative else "J"
    across, up = _angles(momentum)
    along, north = _angles(ecliptic)
    equator = (
        f"RA {across:.6f}{errors.of('right_ascension', _DEGREE)} deg, "
        f"Dec {up:+.6f}{errors.of('declination', _DEGREE)} deg"
    )
    plane = (
        f"longitude {along:.6f}{errors.of('longitude', _DEGREE)} deg, "
        f"latitude {north:+.6f}{errors.of('latitude', _DEGREE)} deg"
    )
    return [
        ("momentum", f"{size:.9g}{errors.of('momentum')} {unit}"),
        ("  towards ICRF", equator),
        ("  ecliptic", plane),
        ("energy", f"{motion.energy:.9g}{errors.of('energy')} {unit_of_energy}"),
    ]


def _angles(vector: FloatArray) -> tuple[float, float]:
    """Longitude in [0, 360) and latitude of a vector, degrees."""
    longitude, latitude = map(math.degrees, _longitude_and_latitude(vector))
    # A tiny negative angle plus 360 rounds to 360.
    longitude = round(longitude + 360.0 if longitude < 0.0 else longitude, 9) % 360.0
    return longitude, latitude


def _separatrix(motion: FreeRotation, errors: _Errors) -> str:
    distance = motion.separatrix_distance
    if distance == 0.0:
        return "0: on the separatrix"
    side = "short-axis" if distance > 0.0 else "long-axis"
    error = errors.of("separatrix_distance")
    return f"{distance:.6g}{error}: on the {side} side of the separatrix, which is at 0"


# ---- Standard deviations of the numbers that describe a motion: periods, angles, momentum, energy
# They are computed from motions one standard deviation away along each principal axis of the
# errors, as `_uncertainty.spread` does from published numbers: without derivatives, and with the
# limits that bodies and modes set.

# Angles of a whole turn.
_TURNING = ("right_ascension", "longitude")
# Modes beside which the axis of circulation is the same, unless errors reach the separatrix.
_CIRCULATING = (Mode.LONG_AXIS, Mode.SHORT_AXIS, Mode.SYMMETRIC)


def deviations(motion: FreeRotation, errors: FloatArray) -> dict[str, Uncertain]:
    """The numbers of a motion with their errors of one standard deviation.

    Shapes: errors (9, 9).

    Errors that reach moments of no body, or the separatrix, are cut there, since the periods of the
    other mode are others.
    """
    columns = covariances.factor(errors).T
    steps = [sign * column for column in columns if np.any(column) for sign in (1.0, -1.0)]
    start = np.zeros(9)
    ends = [possible_end(start, step, lambda end: _exists(motion, end)) for step in steps]
    numbers = [_numbers(motion), *(_numbers(motion.changed(end)) for end in ends)]
    names = list(numbers[0])
    values = np.array([list(row.values()) for row in numbers])
    for name in _TURNING:
        k = names.index(name)
        away = values[1:, k] - values[0, k]
        values[1:, k] = values[0, k] + (away + math.pi) % (2.0 * math.pi) - math.pi
    return dict(zip(names, in_quadrature(values), strict=True))


def _exists(motion: FreeRotation, changes: FloatArray) -> bool:
    """Whether a change of the parameters leaves a body, and the axis of circulation."""
    try:
        other = motion.changed(changes)
    except AttitudeError:
        return False
    return motion.mode not in _CIRCULATING or other.circulates_about == motion.circulates_about


def _numbers(motion: FreeRotation) -> dict[str, float]:
    regime, axis = motion.regime, motion.circulates_about
    nutation = (math.nan, math.nan) if axis is None else regime.nutation(axis[0])
    speed = float(regime.spin_rate)
    momentum = np.asarray(motion.momentum)
    ecliptic = frames.matrix_to_icrf("ecliptic").T @ momentum
    right_ascension, declination = _longitude_and_latitude(momentum)
    longitude, latitude = _longitude_and_latitude(ecliptic)
    return {
        "spin_rate": speed,
        "period": math.inf if speed == 0.0 else 2.0 * math.pi / speed,
        "period_psi": motion.period_psi,
        "period_phi": motion.period_phi,
        "P_phi_L": float(regime.P_phi_L),
        "P_phi_S": float(regime.P_phi_S),
        "nutation_least": float(nutation[0]),
        "nutation_greatest": float(nutation[1]),
        "spin_rate_least": float(regime.spin_rate_range[0]),
        "spin_rate_greatest": float(regime.spin_rate_range[1]),
        "spin_rate_mean": float(regime.mean_spin_rate),
        "energy_ratio": float(regime.energy_ratio),
        "one_minus_m": float(regime.one_minus_m),
        "momentum": float(np.linalg.norm(momentum)),
        "right_ascension": right_ascension,
        "declination": declination,
        "longitude": longitude,
        "latitude": latitude,
        "energy": motion.energy,
        "separatrix_distance": motion.separatrix_distance,
    }


def _longitude_and_latitude(vector: FloatArray) -> tuple[float, float]:
    """Longitude from -pi to pi and latitude, rad; NaN for no vector."""
    if not np.any(vector):
        return math.nan, math.nan
    x, y, z = vector / np.max(np.abs(vector))
    return math.atan2(y, x), math.atan2(z, math.hypot(x, y))
