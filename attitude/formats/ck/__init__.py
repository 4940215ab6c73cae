"""SPICE C-kernels.

ck             `write`: C-kernel, frame kernel and clock kernel of a motion
attitude       `KernelAttitude`: the attitude of a frame from any C-kernel
plan           the span of a kernel on its clock, and the step between its records
clock          the clock of a kernel: its own, or a mission's
table_segments the records of a table as segments
kernel_files   the segments of a C-kernel, its errors, the texts of frame and clock kernel
spice_pool     kernels loaded in SPICE's pool, which keeps what the user has loaded
daf_head       the head of a binary kernel, checked
"""

from attitude.formats.ck.attitude import KernelAttitude
from attitude.formats.ck.ck import Written, write

__all__ = ["KernelAttitude", "Written", "write"]
