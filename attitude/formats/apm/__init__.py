"""CCSDS Attitude Parameter Messages.

apm       `read` and `write`
blocks    the blocks of either notation and version under one set of names
state     the state that the blocks hold
inertia   the signs of products of inertia
written   blocks, written
"""

from attitude.formats.apm.apm import read, write

__all__ = ["read", "write"]
