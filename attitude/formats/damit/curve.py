"""One light curve of an asteroid with its geometry, in the units of DAMIT."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, frames, pairs, validation
from attitude.errors import AttitudeError
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.immutable import Immutable, frozen
from attitude.physical_constants import ASTRONOMICAL_UNIT_M

if TYPE_CHECKING:
    from astropy.time import Time
    from numpy.typing import ArrayLike

    from attitude.annotations import Epoch, Epochs, FloatArray, Reals


@dataclass(frozen=True, eq=False, repr=False, init=False)
class DamitLightCurve(Immutable):
    """One light curve of an asteroid with its geometry.

    Parameters
    ----------
    jd : (N,) array_like
        Julian dates at which the light left the asteroid.
    brightness : (N,) array_like
        Above zero, in units of intensity.
    sun, earth : (N, 3) array_like
        Vectors from the asteroid, au, ecliptic J2000 axes.
    calibrated : bool
        Whether the unit of brightness is shared with other curves.
    time_system : str
        Time scale of the dates: "UTC", "TAI", "TT", "TDB", ...  The files do not state it; they
        differ by about a minute, which does not matter for most asteroids.
    jd_low : (N,) array_like, optional
        The dates are jd + jd_low, accurate to the microsecond and below.

    Attributes
    ----------
    jd, brightness, sun, earth, jd_low : arrays
        Read-only.
    calibrated, time_system
        As given.

    Raises
    ------
    AttitudeError
        For shapes and values other than these, and intensities that are not above zero.

    >>> curve = DamitLightCurve([2460000.5], [1.0], [[1, 0, 0]], [[0, 0, 1]], calibrated=False)
    >>> curve.phase_angle
    array([1.57079633])
    """

    jd: FloatArray
    brightness: FloatArray
    sun: FloatArray
    earth: FloatArray
    calibrated: bool
    time_system: str
    jd_low: FloatArray

    def __init__(
        self,
        jd: ArrayLike,
        brightness: ArrayLike,
        sun: ArrayLike,
        earth: ArrayLike,
        calibrated: bool,
        time_system: str = "TDB",
        jd_low: ArrayLike | None = None,
    ):
        self._set("jd", frozen(validation.real(jd, "jd")))
        if self.jd.ndim != 1 or not self.jd.size:
            raise AttitudeError(f"jd has shape {self.jd.shape}; give (N,), one point or more.")
        count = len(self.jd)
        low = np.zeros(count) if jd_low is None else jd_low
        self._set("jd_low", frozen(validation.real(low, "jd_low", shape=(count,))))
        self._set("brightness", frozen(validation.real(brightness, "brightness", shape=(count,))))
        for name, vectors in (("sun", sun), ("earth", earth)):
            self._set(name, frozen(validation.real(vectors, name, shape=(count, 3))))
        _astropy_scale(time_system)
        self._set("time_system", time_system)
        if not isinstance(calibrated, (bool, np.bool_)):
            raise AttitudeError(f"calibrated is {calibrated!r}; give True or False.")
        self._set("calibrated", calibrated)
        for k in np.flatnonzero(~(self.brightness > 0.0))[:1]:
            raise AttitudeError(
                f"brightness[{k}] is {float(self.brightness[k])}; intensities are above zero. "
                "Convert magnitudes by 10**(-0.4 * magnitude)."
            )
        for name in ("sun", "earth"):
            for k in np.flatnonzero(~np.any(getattr(self, name), axis=1))[:1]:
                raise AttitudeError(
                    f"{name}[{k}] is zero; give the vector from the asteroid in au."
                )

    def __len__(self) -> int:
        return len(self.jd)

    def __repr__(self) -> str:
        kind = "calibrated" if self.calibrated else "relative"
        return f"<DamitLightCurve, {kind}: {len(self)} points from JD {self.jd[0]:.5f}>"

    @cached_property
    def time(self) -> Time:
        """The dates as an astropy Time in their time scale."""
        from astropy.time import Time

        scale = _astropy_scale(self.time_system)
        return Time(self.jd, self.jd_low, format="jd", scale=scale)

    def seconds_since(self, epoch: Epoch) -> tuple[FloatArray, FloatArray | None]:
        """TDB seconds since an epoch: (seconds, low), the arguments of ``motion.at``.

        The dates are corrected for light time, so that they are epochs of the motion.
        """
        return epochs.seconds_since(epochs.instant(epoch), self.time)

    @property
    def sun_direction(self) -> FloatArray:
        """(N, 3) unit vectors to the Sun, ICRF axes."""
        return _icrf_units(self.sun)

    @property
    def earth_direction(self) -> FloatArray:
        """(N, 3) unit vectors to the Earth, ICRF axes."""
        return _icrf_units(self.earth)

    @property
    def phase_angle(self) -> FloatArray:
        """(N,) angles at the asteroid between Sun and Earth, rad."""
        s, e = _icrf_units(self.sun), _icrf_units(self.earth)
        return 2.0 * np.arctan2(
            np.sqrt(np.sum((s - e) ** 2, axis=-1)), np.sqrt(np.sum((s + e) ** 2, axis=-1))
        )

    @property
    def magnitude(self) -> FloatArray:
        """(N,) magnitudes, -2.5 lg of the brightness: relative to an unknown zero point."""
        return -2.5 * np.log10(self.brightness)


def from_positions(
    t: Epochs,
    brightness: ArrayLike,
    sun: Reals,
    earth: Reals,
    *,
    calibrated: bool,
    time_system: str = "TDB",
    frame: str = "icrf",
) -> DamitLightCurve:
    """A `DamitLightCurve` from epochs and vectors in metres.

    Parameters
    ----------
    t : astropy Time, dates
        Epochs at which the light left the asteroid; (N,).
    brightness : (N,) array_like
        Above zero, in units of intensity.
    sun, earth : (N, 3) array_like
        Vectors from the asteroid, m or a Quantity.
    calibrated : bool
        Whether the unit of brightness is shared with other curves.
    time_system : str
        Time scale of the dates of the curve.
    frame : str
        Axes of the vectors: "icrf", "gcrf", "eme2000" or "ecliptic".

    Raises
    ------
    AttitudeError
        As `DamitLightCurve`, and for epochs that cannot be read.
    """
    hi, lo = epochs.seconds_since(epochs.Instant(0.0), t)
    instants = epochs.times(epochs.Instant(0.0), np.atleast_1d(hi), lo)
    dates = getattr(instants, _astropy_scale(time_system))
    turn = frames.matrix_to_icrf("ecliptic").T @ frames.matrix_to_icrf(frame)
    to_sun, to_earth = (
        validation.real(v, name, shape=(..., 3), unit="m") @ turn.T / ASTRONOMICAL_UNIT_M
        for v, name in ((sun, "sun"), (earth, "earth"))
    )
    jd, low = pairs.two_sum(dates.jd1, dates.jd2)
    return DamitLightCurve(
        jd,
        brightness,
        to_sun,
        to_earth,
        calibrated=calibrated,
        time_system=time_system,
        jd_low=low,
    )


def _astropy_scale(time_system):
    """The time scale of a time system, in lower case; AttitudeError if astropy has none."""
    scale = ccsds_epochs.known(time_system, "time_system")
    if scale == "gps":
        raise AttitudeError(
            'time_system "GPS" has no Julian dates of its own; give "TAI" or "UTC".'
        )
    return scale


def _icrf_units(vectors):
    turned = vectors @ frames.matrix_to_icrf("ecliptic").T
    return turned / np.sqrt(np.sum(turned * turned, axis=-1, keepdims=True))
