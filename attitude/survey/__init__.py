"""Light curves of rotating bodies in simulations of surveys.

_rotators      `Rotators`: states from columns or drawn, and their light relative to its mean
_light_curve   `LightCurve` for Rubin's simulator sorcha; needs the extra ``sorcha``
__main__       ``python -m attitude.survey run ...``: sorcha's command with the class registered

Importing this package registers the class with sorcha if sorcha is installed.
"""

from __future__ import annotations

import warnings
from importlib.util import find_spec
from typing import Any

from attitude.survey._rotators import Rotators

__all__ = ["RELAXED", "LightCurve", "Rotators", "light_curve_class"]

if find_spec("sorcha") is not None:
    with warnings.catch_warnings():
        # Packages that sorcha imports warn of what is deprecated in others.
        warnings.simplefilter("ignore")
        from attitude.survey._light_curve import RELAXED, LightCurve, light_curve_class


def __getattr__(name: str) -> Any:
    if name in ("RELAXED", "LightCurve", "light_curve_class"):
        from attitude._support import validation
        from attitude.errors import AttitudeError

        raise AttitudeError(
            f"{name} is part of the light-curve class for the simulator sorcha, which is not "
            f"installed; install it by {validation.installing('sorcha')}."
        )
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
