"""Brightness at 1 au from Sun and observer, when the light left the body, at zero phase angle."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, paths, scattering, validation
from attitude.errors import AttitudeError
from attitude.physical_constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S
from attitude.scene import Scene

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real
    from attitude.paths import Path
    from attitude.photometry.table import Photometry

# Rounds of the correction of a date at the barycenter: each gains four digits.
_ROUNDS = 4
_CENTERS = {"barycenter": None, "heliocenter": "sun"}


def reduced(
    data: Photometry,
    path: Path | None = None,
    *,
    site: Any = None,
    phase_function: Callable[[FloatArray], FloatArray] | str | None = None,
    g: Real | None = None,
) -> Photometry:
    """The photometry at 1 au from Sun and observer, at the times at which light left the body.

    Parameters
    ----------
    data : Photometry
    path : Path, optional
        Of the body; not needed where the data have vectors to Sun and observer.
    site : Path, name, dict of them by the names of sites, optional
        The observer; by default the sites of the data (codes of observatories, or longitude and
        latitude), and the centre of the Earth for points without a site.
    phase_function : callable or "hg", optional
        Mean magnitude as a function of the phase angle in rad, which is taken off less its value
        at zero; "hg" with `g` (0.15).
    g : float, optional
        Slope parameter: the same as phase_function="hg".

    Returns
    -------
    Photometry
        With `sun` and `observer`, ``time_of="emission"``.

    Raises
    ------
    AttitudeError
        Without a path and vectors, and for sites that are not known.

    Notes
    -----
    Light time as in `Scene`; dates of light at the barycenter of the solar system are converted to
    those of reception first, to 1e-6 s for a body beyond 0.01 au.
    """
    if path is None and (data.sun is None or data.observer is None):
        raise AttitudeError(
            "the photometry has no vectors to Sun and observer; give the path of the body, as in "
            "reduced(paths.mpc_orbit(line)) or reduced(paths.oem(file))."
        )
    if path is None:
        sun, observer = np.array(data.sun), np.array(data.observer)
        received = data.seconds
    else:
        sun, observer, received = _from_path(data, path, site)
    far = [np.linalg.norm(each, axis=1) for each in (sun, observer)]
    left = received if data.time_of == "emission" else received - far[1] / SPEED_OF_LIGHT_M_S
    shift = np.zeros(len(data))
    if not data.unit_distances:
        shift -= 5.0 * np.log10(far[0] * far[1] / ASTRONOMICAL_UNIT_M**2)
    function = _function(phase_function, g)
    if function is not None:
        if data.zero_phase:
            raise AttitudeError("the photometry is at zero phase angle already.")
        alpha = np.arctan2(
            np.linalg.norm(np.cross(sun, observer), axis=1), np.sum(sun * observer, axis=1)
        )
        shift -= function(alpha) - function(np.zeros(1))[0]
    factor = 10.0 ** (-0.4 * shift)
    changed: dict[str, Any] = {"magnitude": data.value + shift}
    if data.is_flux:
        changed = {"flux": data.value * factor, "sigma": data.sigma * factor}
    return data.replaced(
        times=left,
        sun=sun,
        observer=observer,
        time_of="emission",
        unit_distances=True,
        zero_phase=data.zero_phase or function is not None,
        **changed,
    )


def phase_angle(data: Photometry) -> FloatArray:
    """Angle (N,) at the body between Sun and observer, rad; AttitudeError without vectors."""
    if data.sun is None or data.observer is None:
        raise AttitudeError("the photometry has no vectors to Sun and observer; see reduced.")
    cross = np.linalg.norm(np.cross(data.sun, data.observer), axis=1)
    found: FloatArray = np.arctan2(cross, np.sum(data.sun * data.observer, axis=1))
    return found


def _function(given: Any, g: Real | None) -> Callable[[FloatArray], FloatArray] | None:
    if given is None and g is None:
        return None
    if given is None or given == "hg":
        slope = 0.15 if g is None else validation.number(g, "g")
        return lambda alpha: scattering.hg(alpha, 0.0, slope)
    if g is not None or not callable(given):
        raise AttitudeError(
            f"phase_function is {validation.shown(given)}; give a function of the phase angle in "
            'rad without g, or "hg" with g.'
        )
    return given


def _from_path(
    data: Photometry, path: Path, site: Any
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Vectors (N, 3) to Sun and observer, m, and seconds (N,) of reception, or of emission."""
    sun, observer = np.empty((len(data), 3)), np.empty((len(data), 3))
    received = np.array(data.seconds)
    light_time = data.time_of != "emission"
    for number, name in enumerate(data.sites):
        here = data.site == number
        scene = Scene(None, path, _place(name, site), light_time=light_time)
        if data.time_of in _CENTERS:
            received[here] = _received(data, here, scene)
        view = scene.at(epochs.times(data.epoch, received[here]))
        for out, key in ((sun, "sun"), (observer, "observer")):
            unit = getattr(view, f"{key}_direction_icrf")
            out[here] = unit * np.reshape(getattr(view, f"{key}_distance"), (-1, 1))
    return sun, observer, received


def _received(data: Photometry, here: Any, scene: Scene) -> FloatArray:
    """Seconds of reception from those of light in the plane through the barycenter or the Sun."""
    given = data.seconds[here]
    found = np.array(given)
    center = _CENTERS[data.time_of]
    assert scene.center is not None
    for _ in range(_ROUNDS):
        view = scene.at(epochs.times(data.epoch, found))
        towards = -view.observer_direction_icrf
        place = scene.observer.position(data.epoch, found)  # type: ignore[union-attr]
        if center is not None:
            place = place - paths.body(center).position(data.epoch, found)
        found = given - np.sum(place * towards, axis=-1) / SPEED_OF_LIGHT_M_S
    return found


def _place(name: str, site: Any) -> Any:
    """The observer of points of a site."""
    if isinstance(site, dict):
        if name not in site:
            raise AttitudeError(f"site has no {name!r}; it has {', '.join(map(repr, site))}.")
        return site[name]
    if site is not None:
        return site
    if not name:
        return "earth"
    if "," in name:
        longitude, latitude = validation.real(name, "site", shape=(2,), unit="rad")
        return paths.site(longitude, latitude)
    try:
        return paths.observatory(name)
    except AttitudeError as err:
        raise AttitudeError(f"{err} Or give site= for points of {name!r}.") from None
