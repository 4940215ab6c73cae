"""Quantities of a view as observables: with extrema, and conditions by comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import paths, validation
from attitude.conditions.moments import OfReception
from attitude.conditions.observable import Observable
from attitude.errors import AttitudeError
from attitude.scene.view import View

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray, Real
    from attitude.conditions.moments import Moment, Pair
    from attitude.paths.path import Path
    from attitude.scene.scene import Scene

# Quantities that are true or false, that have kinks or jumps, and that may be NaN or infinite: all
# others are smooth, so that their samples bound their derivatives.
_FLAGS = ("in_umbra", "in_penumbra", "sky_dark")
_ROUGH = ("lit_fraction", "airmass", "brightness", "reduced_magnitude", "magnitude")
_JUMPS = ("longitude", "right_ascension")
# Parts of |r| / |v| that are the spacing of samples: of a body or observer about its center, and of
# the two relative to each other.
_OF_ORBIT, _OF_RANGE = 1.0 / 30.0, 1.0 / 4.0
_SAMPLES, _FEWEST = 129, 16


@dataclass(frozen=True)
class OfColumn:
    """A quantity of a view by name, or one part of its last axis; for a block of epochs."""

    name: str
    number: int | None = None

    def __call__(self, moment: Moment) -> FloatArray:
        """The values (N,)."""
        found = np.asarray(getattr(moment.view, self.name), dtype=np.float64)
        return found if self.number is None else found[..., self.number]


@dataclass(frozen=True)
class OfFunction:
    """A function of a view, for a block of epochs."""

    function: Callable[[View], ArrayLike]

    def __call__(self, moment: Moment) -> FloatArray:
        """The values (N,)."""
        found = np.asarray(self.function(moment.view), dtype=np.float64)
        if found.shape != moment.hi.shape:
            raise AttitudeError(
                f"the function of a view returns shape {found.shape} for {moment.hi.size} epochs; "
                "it must return one number for each."
            )
        return found


class OfView(Observable):
    """A number of a view at every epoch of reception; made by ``scene.quantity``.

    Attributes
    ----------
    name : str
        Of the quantity, or "function".
    is_flag : bool
        Whether it is true or false, and so a condition itself.
    """

    def __init__(
        self,
        scene: Scene,
        value: OfColumn | OfFunction,
        name: str,
        *,
        is_flag: bool = False,
        **options: Any,
    ) -> None:
        super().__init__(OfReception(scene), value, **options)
        self.name, self.is_flag = name, is_flag

    @property
    def key(self) -> Hashable:
        """The quantity, with the stated step and rate."""
        return self.value, self.step, self.rate

    def spacing(self, start: Pair, stop: Pair) -> float:
        """The spacing of samples in a span, s: `step`, or from what the value depends on.

        An attitude: 0.05 rad of the fastest rotation.  Lines of sight: a thirtieth of |r| / |v| of
        the body and of the observer about their centers, the least of samples in the span.
        """
        if self.step is not None:
            return self.step
        length = (stop[0] - start[0]) + (stop[1] - start[1])
        s = np.linspace(0.0, length, _SAMPLES)
        moment = self.source.at(start[0] + s, np.full(s.size, start[1]))
        self.value(moment)
        found = [length / _FEWEST] if length > 0.0 else [1.0]
        if "attitude" in moment.view.evaluated:
            found.append(super().spacing(start, stop))
        found += _scales(moment.view)
        return min(found)

    def __repr__(self) -> str:
        return f"<{self.name}{f' in {self.unit}' if self.unit else ''} of a scene>"


def quantity(
    scene: Scene,
    given: str | Callable[[View], ArrayLike],
    *,
    unit: str = "",
    rate: Real | None = None,
    step: Real | None = None,
) -> OfView:
    """The Observable of ``scene.quantity``, whose docstring describes the arguments."""
    stated = None if rate is None else validation.positive(rate, "rate", unit=_per_second(unit))
    known_step = None if step is None else validation.positive(step, "step", unit="s")
    options: dict[str, Any] = {"rate": stated, "step": known_step}
    if not isinstance(given, str):
        if not callable(given):
            raise AttitudeError(
                f"quantity is {validation.shown(given)}; give the name of a quantity of a view, "
                'such as "elevation", or a function of a view.'
            )
        return OfView(scene, OfFunction(given), "function", unit=unit, **options)
    name, _, part = given.partition(".")
    known = View.columns()
    if name not in known:
        raise AttitudeError(
            f"{given!r} is not a quantity of a view; give one of {', '.join(known)}."
        )
    parts = known[name].parts
    if parts and part not in parts:
        raise AttitudeError(
            f'{name} has the parts {", ".join(parts)}; give one of them, as in "{name}.{parts[0]}".'
        )
    if part and not parts:
        raise AttitudeError(f"{name} has no parts; give {name!r}.")
    own = known[name].unit
    if unit and unit != own:
        raise AttitudeError(
            f"{name} is in {own or 'no unit'}; leave unit out, and give thresholds with their "
            'units, as in > "10 deg".'
        )
    is_flag = name in _FLAGS
    smooth = not (is_flag or name in _ROUGH or part in _JUMPS or name.endswith("_sigma"))
    value = OfColumn(name, parts.index(part) if part else None)
    return OfView(scene, value, given, unit=own, is_smooth=smooth, is_flag=is_flag, **options)


def _per_second(unit: str) -> str:
    return f"{unit} / s" if unit else "1 / s"


def _scales(view: View) -> list[float]:
    """Spacings of samples of what depends on lines of sight, s."""
    scene = view.scene
    found: list[float] = []

    def least(path: Path, part: float) -> None:
        position, velocity = path.state(view.epoch, view.seconds, view.low)
        size, speed = (np.sqrt(np.sum(each * each, axis=-1)) for each in (position, velocity))
        moving = (speed > 0.0) & (size > 0.0)
        if np.any(moving):
            found.append(part * float(np.min(size[moving] / speed[moving])))

    places = [each for each in (scene.center, scene.observer) if isinstance(each, paths.Path)]
    for place in places:
        least(place, _OF_ORBIT)
    if len(places) == 2:
        least(paths.relative(places[0], places[1], scene.ephemeris), _OF_RANGE)
    return found
