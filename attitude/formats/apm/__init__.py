"""CCSDS Attitude Parameter Messages.

apm        `read` and `write`
keywords   keywords of the blocks of either version, and checks of their values
blocks     messages in KVN and XML, read into blocks with the keywords of version 2
state      attitude, rates and inertia from the blocks
inertia    signs of products of inertia
written    blocks of a message to be written, in KVN and XML
"""

from attitude.formats.apm.apm import Parameters, read, write

__all__ = ["Parameters", "read", "write"]
