"""From rows of a file to an AttitudeTable, and back: frames, directions, units, unit length."""

import numpy as np

from attitude import pairs, quaternion
from attitude import representations as forms
from attitude.attitude_table.table import AttitudeTable, refuse_speed
from attitude.errors import AttitudeError
from attitude.formats.ccsds import attitude_types
from attitude.formats.ccsds import epochs as ccsds_epochs

# How far from 1 the length of a quaternion may be: printed digits are few in some files.
TOLERANCE = 1e-3


def known_tolerance(tolerance):
    """A tolerance of the length of quaternions that a reader was given."""
    number = isinstance(tolerance, (int, float)) and not isinstance(tolerance, bool)
    if not (number and tolerance >= 0.0):
        raise AttitudeError(
            f"tolerance is {tolerance!r}; give how far from 1 the length of a quaternion may be, 0 "
            "or more."
        )
    return tolerance


class Rows:
    """The records of one segment while they are read: epochs, columns and their lines."""

    def __init__(self, scale, width):
        self.scale, self.width = scale, width
        self._hi, self._lo, self._values, self._lines = [], [], [], []
        self._last = None
        self.count = 0

    def add(self, tokens, values, lines, fault):
        """Some records: epochs as bytes, an array of columns, numbers of their lines.

        `fault(sentence, line)` makes the error for what is wrong with a line.
        """
        try:
            hi, lo = ccsds_epochs.parsed(tokens, self.scale)
        except ccsds_epochs.BadEpoch as err:
            shown = tokens[err.index][:60].decode("ascii", "replace")
            raise fault(
                f"the epoch {shown!r} cannot be taken: {err.reason}.", lines[err.index]
            ) from err
        self.add_times(hi, lo, values, lines, fault)

    def add_times(self, hi, lo, values, lines, fault):
        """The same of epochs that are TDB seconds since J2000 already."""
        finite = np.isfinite(values).all(axis=1) & np.isfinite(hi)
        if not np.all(finite):
            k = int(np.argmin(finite))
            raise fault("it holds a number that is not finite.", lines[k])
        before = (
            (hi, lo)
            if self._last is None
            else (np.append(self._last[0], hi), np.append(self._last[1], lo))
        )
        steps = np.diff(before[0]) + np.diff(before[1])
        if np.any(steps <= 0.0):
            k = int(np.argmax(steps <= 0.0))
            what = "is that of the record before" if steps[k] == 0.0 else "goes backwards"
            raise fault(
                f"the epoch {what}; records must follow each other in time.",
                lines[k + (self._last is None)],
            )
        if len(hi):
            self._last = hi[-1:], lo[-1:]
        self._hi.append(hi)
        self._lo.append(lo)
        self._values.append(values)
        self._lines.append(np.asarray(lines))
        self.count += len(hi)

    def table(self, kind, how, axes, fault, *, tolerance=TOLERANCE, orbit=None, **settings):
        """The AttitudeTable of what was added; settings go to it."""
        from attitude.epochs.inputs import Instant

        hi, lo = np.concatenate(self._hi), np.concatenate(self._lo)
        values, lines = np.concatenate(self._values), np.concatenate(self._lines)
        epoch = Instant(float(hi[0]), float(lo[0]))
        seconds = pairs.add((hi, lo), -epoch.seconds, -epoch.low)
        if kind.startswith("QUATERNION"):
            _refuse_length(values[:, :4], lines, tolerance, fault)
        with np.errstate(over="ignore", invalid="ignore"):  # refused by the table, as too fast
            wxyz, rates = attitude_types.decoded(kind, values, how)
        wxyz = forms.unit(wxyz)
        wxyz, rates = to_icrf(wxyz, rates, axes, epoch, *seconds, orbit)
        return AttitudeTable(
            epoch, seconds[0], wxyz, low=seconds[1], angular_velocity=rates, **settings
        )


def to_icrf(wxyz, rates, axes, epoch, hi, lo, orbit=None):
    """Attitudes and rates relative to ICRF, of those relative to other axes."""
    if axes.kind in ("icrf", "gcrf"):
        return wxyz, rates
    refuse_speed(rates)
    wxyz = quaternion.multiply(axes.to_icrf(epoch, hi, lo, orbit), wxyz)
    own = None if rates is None else axes.angular_velocity(epoch, hi, lo, orbit)
    if own is not None:
        rates = rates + quaternion.rotate(quaternion.conjugate(wxyz), own)
    return forms.continuous(wxyz) if axes.turning else wxyz, rates


def columns_of(history, kind, how, axes, orbit=None):
    """The columns of a type for a piece of history, in the units of files."""
    wxyz, rates, acceleration = np.asarray(history.wxyz), None, None
    if attitude_types.has_rates(kind):
        rates = np.asarray(history.angular_velocity)
    if kind in ("SPIN/NUTATION", "SPIN/NUTATION_MOM"):
        if axes.turning:
            raise AttitudeError(f"{kind} can be written in axes that do not turn, not {axes.name}.")
        acceleration = np.asarray(history.angular_acceleration)
    if axes.kind not in ("icrf", "gcrf"):
        low = 0.0 if history.low is None else history.low
        outer = axes.to_icrf(history.epoch, history.seconds, low, orbit)
        own = None
        if rates is not None:
            own = axes.angular_velocity(history.epoch, history.seconds, low, orbit)
        if own is not None:
            rates = rates - quaternion.rotate(quaternion.conjugate(wxyz), own)
        wxyz = quaternion.multiply(quaternion.conjugate(outer), wxyz)
    return attitude_types.encoded(kind, wxyz, rates, acceleration, how)


def _refuse_length(quaternions, lines, tolerance, fault):
    with np.errstate(over="ignore"):
        off = np.abs(np.sqrt(np.sum(quaternions * quaternions, axis=1)) - 1.0)
    if np.any(off > tolerance):
        k = int(np.argmax(off > tolerance))
        raise fault(
            f"the length of the quaternion is off 1 by {off[k]:.3g}; up to {tolerance:g} is taken "
            "for rounding (tolerance=).",
            int(lines[k]),
        )
