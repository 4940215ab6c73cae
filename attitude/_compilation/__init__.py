"""How Python becomes machine code: the only package that imports numba or llvmlite.

decorators     `entry_point`, `subroutine`, `force_inlined`, `reduction`
choice         whether a call runs in Python or compiled
instructions   machine instructions that Python cannot name: fused products, bits of doubles
error_free     the same for processors without them; ieee, the functions of `math`
simd           SIMD vectors of doubles as values; elementary, their powers, angles, logarithms
wide           whole numbers of 448 bits as values
pointers       raw memory and calls by address in compiled loops
lowering       LLVM code of instructions and pointers; simd_lowering, wide_lowering
callbacks      C functions that loops call by address, and the exceptions that leave them
disk_cache     machine code kept on disk, made anew after a change of its sources
deferral       no garbage collection and no Ctrl-C during a compilation
"""
