"""Attitudes in other forms: the names of `attitude.frames.representations`."""

from attitude.frames import representations as _forms
from attitude.frames.representations import *  # noqa: F403

__all__ = list(_forms.__all__)
