"""The source of a search that a caller gives: a motion, an object with ``.at(t)``, or a Scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attitude.catalog import motion_of
from attitude.conditions.moments import OfMotion, OfReception
from attitude.errors import AttitudeError
from attitude.scene.scene import Scene

if TYPE_CHECKING:
    from typing import TypeAlias

    from attitude.conditions.moments import Source
    from attitude.motion import HasAttitudes

    # What a search takes: a Motion, any other object with ``.at(t)``, or a Scene.
    AnyMotion: TypeAlias = HasAttitudes | Scene


def source_of(given: AnyMotion) -> Source:
    """The Source of a motion, of any other object with ``.at(t)``, or of a Scene.

    Raises
    ------
    AttitudeError
        For other objects, and for a Scene without a motion.
    """
    if not isinstance(given, Scene):
        return OfMotion(motion_of(given))
    if given.motion is None:
        raise AttitudeError(
            "the scene has no motion, and this event is one of a rotation; give a scene with a "
            "motion, or compare quantities that need none: scene.quantity(...)."
        )
    return OfReception(given)
