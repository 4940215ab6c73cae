"""How Python becomes machine code: the only package that imports numba or llvmlite.

decorators     `entry_point`, `subroutine`, `reduction` ...; `choice`, what runs in Python
instructions   machine instructions that Python cannot name; `lowering`, `error_free`, their code
simd, wide     vectors of doubles, and whole numbers of 448 bits, as values; `simd_lowering`,
               `wide_lowering`, their code; `elementary`, functions of vectors; `streaming`, stores
pointers       raw memory and calls by address in compiled loops
callbacks      C functions called by address, and the exceptions that leave them
disk_cache     machine code kept on disk, made anew after a change of its sources
deferral       no garbage collection and no Ctrl-C during a compilation
ieee, status   functions of `math` with the results of machine code; what runs compiled
"""
