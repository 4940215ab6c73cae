"""The base class of ephemerides: sources of paths of the bodies of the solar system."""

from __future__ import annotations

import os
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from attitude.errors import AttitudeError
from attitude.paths.bodies import body_name

if TYPE_CHECKING:
    from attitude.paths.path import Path


class Ephemeris:
    """Bodies of the solar system by name or NAIF number; the base of all sources of them.

    What a new source defines
    -------------------------
    ``source``
        Text with the origin of the numbers; also the ``source`` of the paths.
    ``bodies``
        The names of all bodies of the source and of the centers of their paths, as
        `bodies.body_name` spells them.
    ``_step(name)``
        The `Path` of one of these bodies, or None for a body that the source lacks.  The
        ``center`` of that path is the name of another body of the source; the chain of centers
        ends at "ssb", the solar system barycentre.  `step` calls ``_step`` once for each body.
    ``advice`` (optional)
        End of the error message for a body that the source lacks: what the user can do.

    A new source needs a file of its own and one line in `solar_system.SOURCES`: `paths.ephemeris`,
    `Scene` and mission files take the name in that table.  The first two also take an Ephemeris
    object, without that line.

    >>> import numpy as np
    >>> class Resting(Ephemeris):
    ...     '''A Sun at the barycentre, and an Earth at rest.'''
    ...     source, bodies = "two fixed points", ("ssb", "sun", "earth")
    ...     def _step(self, name):
    ...         from attitude import paths
    ...         places = {"sun": (0.0, 0.0, 0.0), "earth": (1.5e11, 0.0, 0.0)}
    ...         return paths.fixed(places[name], name=name) if name in places else None
    >>> from attitude import epochs, paths
    >>> path = paths.body("earth", Resting(), center="sun")
    >>> path.position(epochs.instant("2026-01-01"), np.zeros(1))
    array([[1.5e+11, 0.0e+00, 0.0e+00]])
    """

    source: str = "given"
    advice: str = "Give one of these, or another ephemeris."

    @property
    def bodies(self) -> tuple[str, ...]:
        """The names of the bodies, and of the centers of their paths."""
        raise NotImplementedError(f"{type(self).__name__} defines no bodies")

    @cached_property
    def _steps(self) -> dict[str, Path]:
        """The results of `_step` by the names of the bodies."""
        return {}

    def step(self, body: str | int) -> Path:
        """The path of a body relative to the center that this source gives the body.

        Parameters
        ----------
        body : str or int
            A name or a NAIF number.

        Raises
        ------
        AttitudeError
            For a name that is not known, and a body that the source lacks.
        """
        name = body_name(body)
        if name not in self._steps:
            found = self._step(name)
            if found is None:
                raise AttitudeError(self._lacks(name))
            self._steps[name] = found
        return self._steps[name]

    def _step(self, name: str) -> Path | None:
        """The path of a body by its name, or None for a body that the source lacks."""
        raise NotImplementedError(f"{type(self).__name__} defines no _step")

    def _lacks(self, name: str) -> str:
        """The error message for a body that the source lacks."""
        hint = ""
        if f"{name} barycenter" in self.bodies:
            hint = f' It has the barycentre of its system: "{name} barycenter".'
        return (
            f"the ephemeris ({self.source}) has no {name}; it has {', '.join(self.bodies)}.{hint} "
            f"{self.advice}"
        )

    def __repr__(self) -> str:
        return f"<{self.source}: {', '.join(self.bodies)}>"


# Arguments of `solar_system.ephemeris`: an ephemeris, a file, a name, or None for the default.
EphemerisLike: TypeAlias = Ephemeris | str | os.PathLike[str] | None
