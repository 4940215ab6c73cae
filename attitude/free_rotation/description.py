"""A motion as text: the output of `print(motion)` and of the command `describe`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from attitude import frames
from attitude.regime import Mode

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body
    from attitude.free_rotation.free_rotation import FreeRotation

    Rows: TypeAlias = list[tuple[str, str]]

_DAY = 86400.0
# 1 - m below which the times near the middle axis and of turning over are printed.
_NEAR_SEPARATRIX = 1e-2
_TUMBLING = (Mode.LONG_AXIS, Mode.SHORT_AXIS, Mode.SYMMETRIC)
# Modes within the rounding of the input, and their consequences.
_NEARLY = {
    Mode.SPHERICAL: "three equal moments",
    Mode.PRINCIPAL_AXIS: "rotation about a principal axis",
    Mode.SEPARATRIX: "the separatrix: where the body turns over is decided by the last digits",
    Mode.SYMMETRIC: "a symmetric body",
}


def description(motion: FreeRotation) -> str:
    """The properties of a motion as text of several lines.

    Parameters
    ----------
    motion : FreeRotation

    Returns
    -------
    str
        Mode, periods, momentum (in ICRF and ecliptic coordinates of J2000), energy, distance to
        the separatrix; quantities in the unit of the body's moments.
    """
    phrase = motion.mode.phrase
    rows = [("epoch", f"{motion.spin.epoch.utc_iso} UTC"), ("body", _body(motion.body))]
    rows += _rates(motion)
    rows += _momentum(motion)
    if motion.mode in (*_TUMBLING, Mode.SEPARATRIX):
        rows.append(("1 - 2 E I2 / L^2", _separatrix(motion)))
    rows += [("within rounding", _NEARLY[mode]) for mode in _near(motion)]
    width = max(len(label) for label, _ in rows)
    lines = [f"  {label:<{width}}  {value}" for label, value in rows]
    return "\n".join([phrase[0].upper() + phrase[1:], *lines])


def _body(body: Body) -> str:
    unit = "(relative)" if body.relative else "kg m2"
    return "principal moments " + ", ".join(f"{each:.9g}" for each in body.moments) + f" {unit}"


def _rates(motion: FreeRotation) -> Rows:
    rate = np.degrees(np.linalg.norm(motion.spin.angular_velocity))
    if motion.mode is Mode.AT_REST:
        return []
    slow = f" = {rate * _DAY:.9g} deg/d" if rate < 0.1 else ""
    rows = [("angular velocity", f"{rate:.9g} deg/s{slow} at the epoch")]
    if motion.mode in (Mode.SPHERICAL, Mode.PRINCIPAL_AXIS):
        rows.append(("period", period(360.0 / rate)))
        if _about_middle(motion):
            rows.append(("stability", "about the middle axis: any disturbance turns the body over"))
        return rows
    if motion.mode is Mode.SEPARATRIX:
        return [*rows, ("period psi", period(motion.period_psi))]
    return [*rows, *_periods(motion), *_ranges(motion)]


def _periods(motion: FreeRotation) -> Rows:
    axis = motion.circulates_about
    other = "short" if axis == "long" else "long"
    name = "axis of symmetry" if motion.mode is Mode.SYMMETRIC else f"{axis} axis"
    rows = [
        ("period psi", f"{period(motion.period_psi)}: rotation about the {name}"),
        ("period phi", f"{period(motion.period_phi)}: {name} about the momentum"),
    ]
    if motion.mode is not Mode.SYMMETRIC:
        letter = other[0].upper()
        seconds = float(motion.regime.P_phi(letter))
        rows.append(("", f"{period(seconds)}: {other} axis, convention {letter}"))
    return rows


def _ranges(motion: FreeRotation) -> Rows:
    regime, axis = motion.regime, motion.circulates_about
    low, high = np.degrees(regime.nutation("L" if axis == "long" else "S"))
    if motion.mode is Mode.SYMMETRIC:
        angle = f"{low:.6g} deg between axis of symmetry and momentum"
    else:
        angle = f"{low:.6g} to {high:.6g} deg between {axis} axis and momentum"
    slow, fast = np.degrees(regime.spin_rate_range)
    mean = np.degrees(float(regime.mean_spin_rate))
    rows = [
        ("nutation", angle),
        ("spin rate", f"{_rate(slow)} to {_rate(fast)}, {_rate(mean)} in the mean"),
        ("2 E C / L^2", f"{float(regime.energy_ratio):.9g} (E/E0)"),
        ("1 - m", f"{float(regime.one_minus_m):.6g} (0 on the separatrix)"),
    ]
    if motion.mode is not Mode.SYMMETRIC and float(regime.one_minus_m) < _NEAR_SEPARATRIX:
        flip, dwell = period(float(regime.flip_time)), period(float(regime.dwell_time))
        rows.append(("turning over", f"takes {flip}; near the middle axis for {dwell} in between"))
    return rows


def _rate(degrees: float) -> str:
    """A rate in deg/s, or in deg/d if it is below 0.1 deg/s."""
    return f"{degrees:.6g} deg/s" if degrees >= 0.1 else f"{degrees * _DAY:.6g} deg/d"


def period(seconds: float) -> str:
    """A period in seconds, and in hours and days if it is at least 0.1 of them.

    >>> period(86400.0), period(60.0)
    ('86400 s = 24 h = 1 d', '60 s')
    """
    if math.isinf(seconds):
        return "infinite"
    units = [(seconds, "s"), (seconds / 3600.0, "h"), (seconds / _DAY, "d")]
    return " = ".join(f"{x:.9g} {unit}" for x, unit in units if unit == "s" or x >= 0.1)


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


def _momentum(motion: FreeRotation) -> Rows:
    relative = motion.body.relative
    momentum = motion.momentum
    largest = np.max(np.abs(momentum))
    if largest == 0.0:
        return []
    size = largest * np.linalg.norm(momentum / largest)
    ecliptic = frames.matrix_to_icrf("ecliptic").T @ momentum
    unit = "rad/s times the unit of the moments" if relative else "kg m2/s"
    return [
        ("momentum", f"{size:.9g} {unit}"),
        ("  towards ICRF", "RA {:.6f} deg, Dec {:+.6f} deg".format(*_angles(momentum))),
        ("  ecliptic", "longitude {:.6f} deg, latitude {:+.6f} deg".format(*_angles(ecliptic))),
        (
            "energy",
            f"{motion.energy:.9g} "
            + ("rad2/s2 times the unit of the moments" if relative else "J"),
        ),
    ]


def _angles(vector: FloatArray) -> tuple[float, float]:
    """Longitude in [0, 360) and latitude of a vector, degrees."""
    x, y, z = vector / np.max(np.abs(vector))
    longitude = math.degrees(math.atan2(y, x))
    # A tiny negative angle plus 360 rounds to 360.
    longitude = round(longitude + 360.0 if longitude < 0.0 else longitude, 9) % 360.0
    return longitude, math.degrees(math.atan2(z, math.hypot(x, y)))


def _separatrix(motion: FreeRotation) -> str:
    distance = motion.separatrix_distance
    if distance == 0.0:
        return "0: on the separatrix"
    side = "short-axis" if distance > 0.0 else "long-axis"
    return f"{distance:.6g}: on the {side} side of the separatrix, which is at 0"
