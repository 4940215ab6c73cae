"""Motions as pictures that move: a page with three.js, animations, and files for other viewers.

How to use it::

    from attitude import catalog
    from attitude.viewer import animate, view

    motion = catalog.entry("toutatis").motion()
    view(motion, output="toutatis.html")  # a page without a network, to turn by hand
    animate(motion, "toutatis.webp")

_page           `view`, `Viewer`: one HTML file without a network; its scripts are in page/
_animation      `animate`: MP4, GIF, WebP
_czml           `write_czml`: Cesium
_gltf           `write_glb`: any viewer of glTF
_cosmographia   `write_cosmographia`: a catalogue beside a C-kernel
_subject        what is shown: span, attitudes, directions, light curve, surface
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.viewer._animation import animate
from attitude.viewer._cosmographia import write_cosmographia
from attitude.viewer._czml import write_czml
from attitude.viewer._gltf import write_glb
from attitude.viewer._page import Viewer, view

__all__ = ["Viewer", "animate", "view", "write_cosmographia", "write_czml", "write_glb"]

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
