"""Files of DAMIT, the database of asteroid models.

damit         spin files: `read`, `write`
light_curve   light curves
"""

from attitude.formats.damit.damit import read, write

__all__ = ["read", "write"]
