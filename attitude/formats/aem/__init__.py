"""CCSDS Attitude Ephemeris Messages.

aem           `read` and `write`
message       header and segments of a message, checked and made an AttitudeTable
kvn           KEYWORD = value notation, read and written
xml           XML, read
xml_records   runs of records in XML that differ in their texts only, read by a pattern
xml_writer    XML, written
elements      names and units of the elements of XML
written       keywords and rows of a segment to be written
"""

from attitude.formats.aem.aem import read, write

__all__ = ["read", "write"]
