"""DAMIT spin files of relaxed rotators: asteroids that turn about their shortest axis.

The first line has longitude lambda and latitude beta of the pole (deg, ecliptic of J2000) and the
sidereal period P (h); the second the Julian date JD0 and the angle phi0 (deg) at JD0; further lines
are parameters of scattering.  Body to ecliptic is
Rz(lambda) Ry(90 deg - beta) Rz(phi0 + 2 pi (t - JD0) / P).

Source: Durech, Sidorin & Kaasalainen (2010), A&A 513, A46, and the documentation of DAMIT.  JD0
is the date of light-curve inversion, corrected for light time.  Neither source names its time
scale: it is read as TDB unless `time_system` is given.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import frames
from attitude._support import validation
from attitude._support.constants import DAY_S
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import is_number, opened
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs import _inputs, _time_scales
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.formats._format import Format, OpenedFile, refuse_foreign, register
from attitude.formats._sampling import refuse_breaks
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude._support.annotations import FilePath

__all__ = ["RelaxedRotator", "read", "write"]


_HOUR = 3600.0
# Largest angle, rad, between angular velocity and body z that is accepted as rounding.
_ALONG_Z = 1e-9


@dataclass(frozen=True)
class RelaxedRotator:
    """Pole, period and phase of a spin file: its numbers, in its units.

    Attributes
    ----------
    longitude_deg, latitude_deg : float
        Of the pole, ecliptic of J2000.
    period_h : float
        Sidereal period.
    jd0 : float
        Epoch of phi0, Julian date.
    phi0_deg : float
        Angle about the pole at jd0.
    scattering : tuple of str
        The lines behind the first two, unchanged.
    time_system : str
        Time scale of jd0.
    """

    longitude_deg: float
    latitude_deg: float
    period_h: float
    jd0: float
    phi0_deg: float
    scattering: tuple[str, ...] = ()
    time_system: str = "TDB"

    def __post_init__(self) -> None:
        for name in ("longitude_deg", "latitude_deg", "period_h", "jd0", "phi0_deg"):
            object.__setattr__(self, name, validation.number(getattr(self, name), name))
        validation.positive(self.period_h, "period_h")

    @property
    def spin(self) -> Spin:
        """The Spin at JD0, with the ecliptic of J2000 as its frame."""
        scale = ccsds_epochs.known(self.time_system, "time_system")
        if scale in ("utc", "ut1"):
            from astropy.time import Time

            epoch = _inputs.instant(Time(self.jd0, format="jd", scale=scale))
        else:
            pair = _time_scales.seconds_from_jd(np.float64(self.jd0), np.float64(0.0))
            epoch = Instant(*_time_scales.tdb_from(scale, *pair))
        angles = np.radians([self.longitude_deg, 90.0 - self.latitude_deg, self.phi0_deg])
        wxyz = quaternion.from_euler("ZYZ", angles)
        rate = 2.0 * np.pi / (self.period_h * _HOUR)
        return Spin(epoch, wxyz, (0.0, 0.0, rate), frame="ecliptic")

    def motion(self, body: Body | None = None) -> FreeRotation:
        """The FreeRotation of a body from this spin; by default of a body with equal moments.

        The rotation is steady for every body that has z as a principal axis.
        """
        return FreeRotation(body or Body(moments=(1.0, 1.0, 1.0), relative=True), self.spin)


def read(path: FilePath, *, time_system: str = "TDB") -> RelaxedRotator:
    """A spin file as a `RelaxedRotator`.

    Parameters
    ----------
    path : str or path
    time_system : str
        Time scale of JD0.

    Raises
    ------
    AttitudeError
        With file and line, if the file is not a spin file.
    """
    with opened(path) as lines:
        first = _numbers(lines, 3, "lambda, beta and period")
        second = _numbers(lines, 2, "JD0 and phi0")
        further = tuple(lines.text(line).rstrip() for line in lines)
    longitude, latitude, period = first
    if not -90.0 <= latitude <= 90.0:
        raise lines.fault(f"the latitude of the pole is {latitude:g} deg.", 1)
    if not period > 0.0:
        raise lines.fault(f"the period is {period:g} h; it must be greater than zero.", 1)
    ccsds_epochs.known(time_system, "time_system")
    jd0, phi0 = second
    if not 0.0 <= jd0 <= 5373484.5:
        raise lines.fault(f"JD0 is {jd0:g}; give a Julian date.", 2)
    return RelaxedRotator(longitude, latitude, period, jd0, phi0, further, time_system)


def _numbers(lines, count, what):
    for line in lines:
        if not line.strip():
            continue
        words = line.split()
        values = [float(word) for word in words if is_number(word)]
        if not len(words) == len(values) == count or not np.all(np.isfinite(values)):
            raise lines.fault(f"it must hold {what}: {count} numbers.")
        return values
    raise lines.fault(f"the file ends before {what}.")


def write(path: FilePath, motion: FreeRotation, *, scattering: Iterable[str] = ()) -> None:
    """Write the spin of a body that turns steadily about its z axis.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    motion : FreeRotation
        With a steady angular velocity along +z of the body (within 1e-9 rad).
    scattering : iterable of str
        Further lines, such as `RelaxedRotator.scattering` of another file.

    Raises
    ------
    AttitudeError
        For other motions, and a file that cannot be written.
    """
    refuse_foreign(path, "damit")
    refuse_breaks(motion, "a DAMIT spin file")
    rates = motion.spin.angular_velocity
    z = rates[2]
    if not (z > 0.0 and np.hypot(rates[0], rates[1]) <= _ALONG_Z * z):
        raise AttitudeError(
            f"the angular velocity is ({', '.join(f'{r:.6g}' for r in rates)}) rad/s; a DAMIT spin "
            "file holds bodies that turn about their own +z axis. Write tumblers as a TOML file."
        )
    if motion.mode.name not in ("PRINCIPAL_AXIS", "SPHERICAL") and np.any(rates[:2] != 0.0):
        raise AttitudeError("the rotation is not steady; a DAMIT spin file holds relaxed rotators.")
    to_ecliptic = quaternion.conjugate(frames.wxyz_to_icrf("ecliptic"))
    wxyz = quaternion.multiply(to_ecliptic, motion.spin.wxyz_icrf)
    if motion.spin.frame == "ecliptic":
        wxyz = motion.spin.wxyz
    longitude, tilt, phi0 = np.degrees(forms.to_euler("ZYZ", wxyz)).tolist()
    # JD0 is one double, which rounds by up to 2e-5 s: phi0 is the angle at the rounded epoch.
    epoch = np.float64(motion.spin.epoch.seconds), np.float64(motion.spin.epoch.low)
    jd1, jd2 = map(float, _time_scales.jd_from_seconds(*epoch))
    jd0 = jd1 + jd2
    rounding = ((jd0 - jd1) - jd2) * DAY_S
    phi0 = (phi0 + float(np.degrees(z * rounding))) % 360.0
    period = float(2.0 * np.pi / z / _HOUR)
    lines = [f"{longitude % 360.0!r} {90.0 - tilt!r} {period!r}", f"{jd0!r} {phi0!r}", *scattering]
    with written_whole(path, "the spin file") as file:
        file.writelines(f"{line}\n" for line in lines)


def _opened(path):
    rotator = read(path)
    return OpenedFile(rotator.motion(), {"scattering": rotator.scattering})


register(
    Format(
        name="damit",
        module=__name__,
        title="DAMIT",
        endings=(".spin",),
        read=_opened,
        reading=(),
        write=write,
        holds="motion",
        # Three words; a line of TOML has an equals sign, is a comment or names a table.
        resembles=lambda line: (
            len(line.split()) == 3 and b"=" not in line and line[:1] not in b"#["
        ),
    )
)
