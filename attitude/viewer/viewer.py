"""A motion or scene as a page with three.js: one HTML file that needs no network."""

from __future__ import annotations

import html
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from attitude.viewer import page, page_data
from attitude.viewer.subject import subject

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import EpochOrSeconds, FilePath, FloatArray
    from attitude.motion import HasAttitudes
    from attitude.scene import Scene, View
    from attitude.shape import Ellipsoid, Mesh


@dataclass(frozen=True, repr=False)
class Viewer:
    """A page that shows a motion; notebooks show it inline.

    Attributes
    ----------
    html : str
        The whole page.
    title : str
    height : int
        Of the frame in a notebook, pixels.
    """

    html: str
    title: str
    height: int = 640

    def write(self, output: FilePath) -> None:
        """Write the page to a file, which appears whole or not at all."""
        from attitude.textfiles.atomic_write import written_whole

        with written_whole(output) as file:
            file.write(self.html)

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" title="{html.escape(self.title)}" '
            f'style="width:100%;height:{self.height}px;border:0" allowfullscreen></iframe>'
        )

    def __repr__(self) -> str:
        return f"<Viewer of {self.title}: a page of {len(self.html) / 1e3:.0f} kB>"


def view(
    motion: HasAttitudes | Scene,
    *,
    output: FilePath | None = None,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    shape: Ellipsoid | Mesh | None = None,
    title: str | None = None,
    magnitude: tuple[Callable[[View], FloatArray], str] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Viewer:
    """A page that shows a motion, or a scene with its Sun, observer and light curve.

    Parameters
    ----------
    motion : Motion, object with ``.at(t)``, or Scene
        Of a Scene the page shows what the light shows that is received at its times.
    output : str or path, optional
        File to write; by default none.
    start, stop : epochs, or TDB seconds since the epoch of the motion
        By default the span of the motion; of a free rotation three turns of its slower phase.
    shape : Ellipsoid or Mesh, optional
        Drawn in place of the shape of the scene; without either the ellipsoid of inertia, or a box
        where the inertia is unknown.
    title : str, optional
    magnitude : (callable, str), optional
        Magnitudes of a View for the light curve, and the label of their axis; by default apparent
        magnitudes, or reduced ones if the Sun or the observer is a direction.
    progress : callable, optional
        ``progress(done, count)`` is called while the light curve is computed.

    Returns
    -------
    Viewer
        In a notebook it shows itself; `Viewer.write` writes it to a file.

    Raises
    ------
    AttitudeError
        For a span that is empty, out of order, not finite, or so long that more than 400,000
        attitudes are needed; for epochs outside of the motion; for a file that cannot be written.

    Warns
    -----
    AttitudeWarning
        If a mesh has more than 200,000 facets, of which fewer are drawn.

    Notes
    -----
    Attitudes between those of the page follow great circles, which keeps them within 0.1 degree of
    the motion.

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
    >>> view(FreeRotation(Body(moments=(10, 20, 26)), spin), title="the paper's body").title
    "the paper's body"
    """
    what = subject(motion, start, stop, shape=shape, title=title, magnitude=magnitude)
    made = Viewer(page.page(page_data.content(what, progress)), what.title)
    if output is not None:
        made.write(os.fspath(output))
    return made
