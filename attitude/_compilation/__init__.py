"""How Python becomes machine code: the only package that imports numba or llvmlite.

decorators     `entry_point`, `subroutine`, `force_inlined`, `reduction`
instructions   machine instructions that Python cannot name: fused products, bits of doubles
simd           SIMD vectors of doubles as values
pointers       raw memory and calls by address in compiled loops
source_stamp   a hash of the sources on which machine code depends
disk_cache     machine code kept on disk, made anew after a change of its sources
callback_errors  exceptions that leave C callbacks, raised after the loop that called
deferral       no garbage collection and no Ctrl-C during a compilation
"""
