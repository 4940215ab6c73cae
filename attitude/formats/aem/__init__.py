"""CCSDS Attitude Ephemeris Messages.

aem           `read` and `write`
message       what a message says of its segments, checked
kvn, xml      the two notations, read
xml_records   long runs of like records in XML, read by a pattern
elements      names and units of the elements of XML
written       segments, written
"""

from attitude.formats.aem.aem import read, write

__all__ = ["read", "write"]
