"""Time of an epoch with the instructions of older processors, and whether the bits are the same.

numba compiles for the processors that NUMBA_CPU_NAME and NUMBA_CPU_FEATURES name.  Without fused
products in hardware, glibc computes its own in software; on Linux its tunables have it do so here.

    python benchmarks/processors.py
"""

import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

MOMENTS = (10.0, 20.0, 26.0)
WXYZ = (1.0, 0.0, 0.0, 0.0)
CASES = {
    "the paper's example": (1.0, 15.0, 1.0),
    "long-axis mode": (5.0, 1.0, 0.2),
    "a principal axis": (0.0, 0.0, 3.0),
}
TARGETS = {
    "this machine": {},
    "AVX, no FMA": {
        "NUMBA_CPU_NAME": "sandybridge",
        "NUMBA_CPU_FEATURES": "+avx,+sse4.2,+sse4.1,+ssse3,+sse3,+sse2,+cx16,+popcnt",
    },
    "SSE2": {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""},
}
# The C library's own products are then computed as on a processor without the instruction.
SOFTWARE = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2"}


def measure():
    """ns an epoch and a hash of the attitudes, for each case."""
    from attitude import propagate

    t = np.linspace(0.0, 1e4, 10**5)
    memory = np.empty((4, t.size)).T
    found = {}
    for name, rates in CASES.items():
        times = []
        for _ in range(12):
            start = time.perf_counter()
            propagate(MOMENTS, WXYZ, rates, t, out=memory)
            times.append(time.perf_counter() - start)
        bits = hashlib.sha256(np.ascontiguousarray(memory).tobytes()).hexdigest()
        found[name] = min(times) / t.size * 1e9, bits
    print(json.dumps(found))


def main():
    found = {}
    for target, variables in TARGETS.items():
        more = SOFTWARE if variables else {}
        with tempfile.TemporaryDirectory() as cache:
            environment = os.environ | variables | more | {"NUMBA_CACHE_DIR": cache}
            environment["ATTITUDE_COMPILE"] = "always"
            run = [sys.executable, __file__, "measure"]
            result = subprocess.run(run, env=environment, stdout=subprocess.PIPE, check=True)
        found[target] = json.loads(result.stdout)
    print(f"{'ns an epoch':<22}" + "".join(f"{target:>16}" for target in TARGETS) + "   bits")
    for case in CASES:
        row = [found[target][case] for target in TARGETS]
        same = "same" if len({bits for _, bits in row}) == 1 else "DIFFERENT"
        print(f"{case:<22}" + "".join(f"{ns:16.1f}" for ns, _ in row) + f"   {same}")


if __name__ == "__main__":
    measure() if sys.argv[1:] == ["measure"] else main()
