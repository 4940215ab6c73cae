"""Motions as pictures that move: a page with three.js.

viewer        `view`, `Viewer`: one HTML file without a network
subject       what is shown, over which span
poses         attitudes at steps between which great circles suffice
sky           directions to Sun and observer, and the light curve
drawn_shape   the surface that is drawn
poinsot       the rolling ellipsoid of inertia
page_data     the data of a page
page          the HTML; its scripts are in page/
"""

from attitude.viewer.viewer import Viewer, view

__all__ = ["Viewer", "view"]
