"""A motion in words and figures: what `print(motion)` and the command `describe` show."""

import math

import numpy as np

from attitude import frames
from attitude.regime import Mode

_DAY = 86400.0
_TUMBLING = (Mode.LONG_AXIS, Mode.SHORT_AXIS, Mode.SYMMETRIC)
# What would hold after changes in the last places of the input, and what follows from it.
_NEARLY = {
    Mode.SPHERICAL: "three equal moments",
    Mode.PRINCIPAL_AXIS: "rotation about a principal axis",
    Mode.SEPARATRIX: "the separatrix: where the body turns over is decided by the last digits",
    Mode.SYMMETRIC: "a symmetric body",
}


def description(motion):
    """What there is to say about a motion, as text of several lines.

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
    if motion.mode not in (Mode.AT_REST, Mode.SPHERICAL):
        rows.append(("1 - 2 E I2 / L^2", _separatrix(motion)))
    rows += [("within rounding", _NEARLY[mode]) for mode in motion.within_rounding]
    width = max(len(label) for label, _ in rows)
    lines = [f"  {label:<{width}}  {value}" for label, value in rows]
    return "\n".join([phrase[0].upper() + phrase[1:], *lines])


def nutation_range(motion):
    """The least and the greatest angle between the momentum and the axis it circulates about.

    Returns
    -------
    (float, float)
        rad; of the long axis in long-axis mode, of the short axis in short-axis mode, of the axis
        of symmetry of a symmetric body.  NaN in the other modes.

    Notes
    -----
    From van Zon & Schofield (2006), eqs. 3.32-3.36: L^2 - 2 E I_k is never formed by subtraction,
    and angles are arc tangents, so that both are good for a slight wobble and near the separatrix.
    """
    if motion.mode not in _TUMBLING:
        return math.nan, math.nan
    moments = motion.body.moments / motion.body.moments.max()
    rates = motion.body.rates_about_principal_axes(motion.spin.angular_velocity)[:, 0]
    rates = rates / np.max(np.abs(rates))
    order = np.argsort(moments)
    if motion.circulates_about == "long":
        order = order[::-1]
    (i1, i2, i3), (w1, w2, w3) = moments[order], rates[order]
    total = (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
    # D / L^2 of the axes that the momentum circulates about, and of the first; see the paper.
    d1 = (i2 * (i2 - i1) * w2**2 + i3 * (i3 - i1) * w3**2) / total
    d3 = (i1 * (i1 - i3) * w1**2 + i2 * (i2 - i3) * w2**2) / total
    d2 = motion.separatrix_distance
    least = math.atan2(math.sqrt(i1 * d3 / (i1 - i3)), math.sqrt(i3 * d1 / (i3 - i1)))
    most = math.atan2(math.sqrt(i2 * d3 / (i2 - i3)), math.sqrt(i3 * d2 / (i3 - i2)))
    return least, max(least, most)


def _body(body):
    unit = "(relative)" if body.relative else "kg m2"
    return "principal moments " + ", ".join(f"{each:.9g}" for each in body.moments) + f" {unit}"


def _rates(motion):
    rate = np.degrees(np.linalg.norm(motion.spin.angular_velocity))
    rows = [("angular velocity", f"{rate:.9g} deg/s = {rate * _DAY:.9g} deg/d at the epoch")]
    if motion.mode is Mode.AT_REST:
        return []
    if motion.mode in (Mode.SPHERICAL, Mode.PRINCIPAL_AXIS):
        return [*rows, ("period", period(360.0 / rate))]
    if motion.mode is Mode.SEPARATRIX:
        return [*rows, ("period psi", period(motion.period_psi))]
    axis = motion.circulates_about
    low, high = np.degrees(nutation_range(motion))
    if motion.mode is Mode.SYMMETRIC:
        name, angle = "axis of symmetry", f"{low:.6g} deg"
    else:
        name, angle = f"{axis} axis", f"{low:.6g} to {high:.6g} deg"
    return [
        *rows,
        ("period psi", f"{period(motion.period_psi)}: rotation about the {name}"),
        ("period phi", f"{period(motion.period_phi)}: {name} about the momentum, in the mean"),
        ("nutation", f"{angle} between {name} and momentum"),
    ]


def period(seconds):
    """A period in seconds, hours and days.

    >>> period(86400.0)
    '86400 s = 24 h = 1 d'
    """
    if math.isinf(seconds):
        return "infinite"
    return f"{seconds:.9g} s = {seconds / 3600.0:.9g} h = {seconds / _DAY:.9g} d"


def _momentum(motion):
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


def _angles(vector):
    """Longitude in [0, 360) and latitude of a vector, degrees."""
    x, y, z = vector / np.max(np.abs(vector))
    longitude = math.degrees(math.atan2(y, x))
    # A tiny negative angle plus 360 rounds to 360.
    longitude = round(longitude + 360.0 if longitude < 0.0 else longitude, 9) % 360.0
    return longitude, math.degrees(math.atan2(z, math.hypot(x, y)))


def _separatrix(motion):
    distance = motion.separatrix_distance
    if distance == 0.0:
        return "0: on the separatrix"
    side = "short-axis" if distance > 0.0 else "long-axis"
    return f"{distance:.6g}: 0 on the separatrix, {'positive' if distance > 0 else 'negative'} "f"on the {side} side"
