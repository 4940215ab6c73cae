"""SPICE C-kernels.

ck           `write`, and `KernelAttitude` to read
attitude     the attitude of a frame out of any C-kernel
plan         the step between records
kernel       the files of a kernel, written
spice_pool   SPICE's pool of kernels, left as it was
daf_head     the head of a binary kernel, checked
"""

from attitude.formats.ck.attitude import KernelAttitude
from attitude.formats.ck.ck import write

__all__ = ["KernelAttitude", "write"]
