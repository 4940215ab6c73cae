"""Random states about a motion: draws from a covariance or from distributions, kept physical."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import evaluation, frames, quaternion, validation
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.sensitivities import covariance as covariances

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import BoolArray, FloatArray
    from attitude.body import Body
    from attitude.free_rotation.free_rotation import FreeRotation

# States that are checked together.
_BLOCK = 4096
_WIDTHS = {"attitude": 3, "wxyz": 4, "angular_velocity": 3, "moments": 3}


class Drawn(NamedTuple):
    """States of N members.

    Attributes
    ----------
    wxyz : (N, 4) array
        Body to ICRF.
    rates : (N, 3) array
        rad/s over the body axes.
    moments : (N, 3) array or None
        Principal moments; None for those of the motion.
    """

    wxyz: FloatArray
    rates: FloatArray
    moments: FloatArray | None


def drawn(
    motion: FreeRotation,
    count: int,
    seed: int | np.random.Generator,
    covariance: Any,
    distributions: Mapping[str, Any] | None,
) -> Drawn:
    """States drawn about a motion; arguments as of `Ensemble.sample`."""
    generator = validation.generator(seed)
    if distributions is None:
        draw = _of_covariance(motion, covariance, generator)
    else:
        draw = _of_distributions(motion, distributions, generator)
    parts: list[Drawn] = []
    found, tried, most = 0, 0, 10 * count + 100
    while found < count or not parts:
        number = min(count - found, most - tried)
        if number == 0 and count:
            raise AttitudeError(
                f"{tried} draws gave {found} motions whose moments are those of a body; give "
                "smaller errors of the moments."
            )
        some = draw(number)
        if some.moments is not None:
            kept = _physical(some.moments)
            some = Drawn(some.wxyz[kept], some.rates[kept], some.moments[kept])
        parts.append(some)
        found, tried = found + len(some.wxyz), tried + number
    moments = None
    if parts[0].moments is not None:
        moments = np.concatenate([each.moments for each in parts if each.moments is not None])
    arrays = (np.concatenate([each[k] for each in parts]) for k in (0, 1))
    wxyz, rates = arrays
    return Drawn(wxyz, rates, moments)


def tensors(body: Body, moments: FloatArray) -> FloatArray:
    """Inertia tensors (N, 3, 3) of moments (N, 3) about the principal axes of a body."""
    axes = body.principal_axes
    found: FloatArray = (axes * moments[:, None, :]) @ axes.T
    return 0.5 * (found + np.swapaxes(found, 1, 2))


def _of_covariance(
    motion: FreeRotation, covariance: Any, generator: np.random.Generator
) -> Callable[[int], Drawn]:
    spin = motion.spin if covariance is None else motion.spin.with_covariance(covariance)
    if spin.covariance_icrf is None:
        raise AttitudeError(
            "the spin has no covariance; give covariance= or distributions=, or make the spin with "
            "Spin(..., covariance=...)."
        )
    factor = covariances.factor(spin.covariance_icrf)
    exact = not np.any(factor[6:])

    def draw(count: int) -> Drawn:
        changes = generator.standard_normal((count, 9)) @ factor.T
        turn = forms.from_rotation_vector(changes[:, :3])
        wxyz = quaternion.multiply(turn, spin.wxyz_icrf)
        moments = None if exact else motion.body.moments + changes[:, 6:]
        return Drawn(wxyz, spin.angular_velocity + changes[:, 3:6], moments)

    return draw


def _of_distributions(
    motion: FreeRotation, distributions: Mapping[str, Any], generator: np.random.Generator
) -> Callable[[int], Drawn]:
    unknown = [name for name in distributions if name not in _WIDTHS]
    if unknown or not distributions:
        raise AttitudeError(
            f"distributions has {validation.shown(unknown)}; give some of {', '.join(_WIDTHS)}."
        )
    if {"attitude", "wxyz"} <= set(distributions):
        raise AttitudeError("distributions has attitude and wxyz; give one of them.")
    spin = motion.spin
    to_icrf = frames.wxyz_to_icrf(spin.frame)

    def rows(name: str, count: int) -> FloatArray:
        source = distributions[name]
        if hasattr(source, "rvs"):
            size = count if np.ndim(source.rvs(random_state=0)) else (count, _WIDTHS[name])
            given = source.rvs(size=size, random_state=generator)
        else:
            given = source(generator, count)
        return validation.real(given, f"the draw of {name}", shape=(count, _WIDTHS[name]))

    def draw(count: int) -> Drawn:
        wxyz = np.broadcast_to(spin.wxyz_icrf, (count, 4))
        if "attitude" in distributions:
            turns = forms.from_rotation_vector(rows("attitude", count))
            wxyz = quaternion.multiply(to_icrf, quaternion.multiply(turns, spin.wxyz))
        elif "wxyz" in distributions:
            wxyz = quaternion.multiply(to_icrf, rows("wxyz", count))
        rates = np.broadcast_to(spin.angular_velocity, (count, 3))
        if "angular_velocity" in distributions:
            rates = rows("angular_velocity", count)
        return Drawn(wxyz, rates, rows("moments", count) if "moments" in distributions else None)

    return draw


def _physical(moments: FloatArray) -> BoolArray:
    """Whether a body has each of some principal moments (N, 3)."""
    found = np.ones(len(moments), dtype=bool)
    for first in range(0, len(moments), _BLOCK):
        part = moments[first : first + _BLOCK]
        pairs = np.zeros((2, len(part), 3, 2))
        pairs[0, ..., 0] = part
        wxyz = np.ones((len(part), 4))
        found[first + evaluation.faults_of(pairs[0], wxyz, pairs[1])] = False
    return found
