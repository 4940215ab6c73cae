"""What a scene has as its center, observer or Sun: a path, or something infinitely far away."""

import numpy as np
from numpy.typing import ArrayLike

from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError


class Place:
    """The base of `Path` and `Direction`: what other code may read of either.

    Attributes
    ----------
    name : str
        What it is the place of, for messages.
    is_direction : bool
        True of what is infinitely far away, which has no position.
    has_horizon : bool
        True of a place on the ground, which defines `zenith`.
    """

    name: str = "place"
    is_direction: bool = False
    has_horizon: bool = False

    def zenith(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> np.ndarray:
        """Unit vectors (..., 3) towards the zenith, ICRF axes; see `Path.position`.

        Raises
        ------
        AttitudeError
            For a place without a horizon.
        """
        raise AttitudeError(
            f"the observer is {self.name}, which has no horizon; give a ground site: "
            "paths.site(longitude, latitude) or paths.observatory(code)."
        )
