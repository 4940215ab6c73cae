"""Photometry of a tumbling body: files, reduction, periods.

table          `Photometry`: brightness at epochs with errors, filters, sites and sessions
files          `read`: any known format; `named_columns`, `exchange_files`, `contents`
"""

from attitude.photometry.contents import BadRow
from attitude.photometry.files import read
from attitude.photometry.table import Photometry

__all__ = ["BadRow", "Photometry", "read"]
