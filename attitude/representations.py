"""Attitudes in other forms: matrices, Euler angles, rotation vectors and others.

The code is in frames/representations.py.
"""

from attitude.frames import representations as _forms
from attitude.frames.representations import *  # noqa: F403

__all__ = list(_forms.__all__)
