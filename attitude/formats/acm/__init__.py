"""CCSDS Attitude Comprehensive Messages.

acm           `read` and `write`
message       what `read` returns: tables, covariances, body, maneuvers, and the rest
keywords      keywords of the blocks, and their units
blocks        messages in KVN and XML, read into blocks
interpreted   the meaning of the blocks
attitudes     rows of attitudes and covariances
maneuvers     maneuvers as impulses and torques
written       blocks of a message to be written, in KVN and XML
"""

from attitude.formats.acm.acm import read, write
from attitude.formats.acm.maneuvers import Maneuver
from attitude.formats.acm.message import AttitudeCovariance, Comprehensive

__all__ = ["AttitudeCovariance", "Comprehensive", "Maneuver", "read", "write"]
