"""Motions as pictures that move: a page with three.js, animations, and files for other viewers.

viewer        `view`, `Viewer`: one HTML file without a network
animation     `animate`: MP4, GIF, WebP
czml          `write_czml`: Cesium
gltf          `write_glb`: any viewer of glTF
cosmographia  `write_cosmographia`: a catalogue beside a C-kernel
subject       what is shown, over which span
poses         attitudes at steps between which great circles suffice
sky           directions to Sun and observer, and the light curve
drawn_shape   the surface that is drawn
poinsot       the rolling ellipsoid of inertia
page_data     the data of a page
page          the HTML; its scripts are in page/
"""

from attitude.viewer._animation import animate
from attitude.viewer._cosmographia import write_cosmographia
from attitude.viewer._czml import write_czml
from attitude.viewer._gltf import write_glb
from attitude.viewer._page import Viewer, view

__all__ = ["Viewer", "animate", "view", "write_cosmographia", "write_czml", "write_glb"]
