"""STK attitude files (.a).

stk        `read` and `write`
header     version, keywords, axes and the start of the clock
dates      dates as STK writes them, and the times of records
sections   the columns of each section: what they mean
"""

from attitude.formats.stk.stk import read, write

__all__ = ["read", "write"]
