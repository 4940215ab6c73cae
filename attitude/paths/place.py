"""The base class of paths and directions: the center, the observer and the Sun of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray
    from attitude.epochs.instants import Instant
    from attitude.paths.path import Path


class Place:
    """The base of `Path` and `Direction`: the members that other code may use of either.

    Attributes
    ----------
    name : str
        Name of the place, for messages.
    is_direction : bool
        True for a `Direction`, which is infinitely far away and has no position.
    has_horizon : bool
        True for a place on the ground, which defines `zenith_path`.
    """

    name: str = "place"
    is_direction: bool = False
    has_horizon: bool = False

    def zenith(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Unit vectors (..., 3) towards the zenith, ICRF axes; see `Path.position`.

        AttitudeError for a place without a horizon.
        """
        return self.zenith_path.position(instant, seconds, low)

    @property
    def zenith_path(self) -> Path:
        """A path whose position is the vector of 1 m to the zenith, and its velocity the rate.

        AttitudeError for a place without a horizon.
        """
        raise AttitudeError(
            f"the observer is {self.name}, which has no horizon; give a ground site: "
            "paths.site(longitude, latitude) or paths.observatory(code)."
        )

    def pole(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Unit vectors (..., 3) along the axis of ITRS, ICRF axes: north of a ground site.

        AttitudeError as `zenith`.
        """
        return self.zenith(instant, seconds, low)
