"""What does the first write to new memory cost, and what bounds one call of 1e8 epochs?

    python benchmarks/memory.py [--epochs 1e8]

Each line: wall, user and system time in ns an epoch, and page faults.  32 bytes an epoch are the
result of `propagate`.  A virtual machine that returns free memory to its host (free page reporting)
pays for the first touch of such memory, in whatever program: so each call is made twice, on memory
that was not used for 20 s, and at once after as much memory was freed; and beside it zeros are
written to as much new memory.
"""

import argparse
import mmap
import resource
import time

import numpy as np

from attitude import propagate
from attitude._support.arrays import new_array

STATE = (10, 20, 26), (1, 0, 0, 0), (1, 15, 1)
PAUSE = 20.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--epochs", type=float, default=1e8)
    count = int(parser.parse_args().epochs)
    pages()
    t = np.linspace(0.0, 1e4, count)
    propagate(*STATE, t[: 1 << 20])  # compiles, or reads the disk cache
    print(
        f"\n{count:.0e} epochs, ns an epoch{'':24s}{'wall':>9s}{'user':>9s}{'system':>9s}  faults"
    )
    into_used(t)
    for label, call in {
        "zeros into new memory": lambda: zeros(count),
        "propagate": lambda: propagate(*STATE, t),
        "propagate, 2 threads": lambda: propagate(*STATE, t, threads=2),
    }.items():
        measured(label + ", memory just freed", call, count)
        time.sleep(PAUSE)
        measured(label + ", memory long free", call, count)


def into_used(t):
    """Print what zeros and attitudes cost in memory that was written before."""
    memory = zeros(t.size)
    measured("zeros into memory used before", lambda: memory.fill(0.0), t.size)
    measured("propagate into it (out=)", lambda: propagate(*STATE, t, out=memory.T), t.size)


def zeros(count):
    """As much new memory as a result takes, written once."""
    memory = new_array(4, count)
    memory.fill(0.0)
    return memory


def measured(label, call, count):
    """Print what a call costs; its result is freed."""
    before, clock = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    call()
    wall, after = time.perf_counter() - clock, resource.getrusage(resource.RUSAGE_SELF)
    times = wall, after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime
    columns = "".join(f"{each / count * 1e9:9.2f}" for each in times)
    print(f"{label:46s}{columns}{after.ru_minflt - before.ru_minflt:8d}", flush=True)


def pages():
    """The first write to memory of small and of large pages, and to new arrays, ns a byte."""
    size = 64 << 20
    print("first write to 64 MB, ns a byte (least of five)")
    for label, advice in (("small pages", None), ("large pages", "MADV_HUGEPAGE")):
        if advice is None or hasattr(mmap, advice):
            print(f"  {label:44s}{min(_mapped(size, advice) for _ in range(5)):8.3f}")
    for label, make in {
        "8 arrays of 8 MB, numpy.empty": lambda: np.empty(1 << 20),
        "8 arrays of 8 MB, attitude._support.arrays.new_array": lambda: new_array(1 << 20),
    }.items():
        print(f"  {label:44s}{min(_of_arrays(make) for _ in range(5)):8.3f}")


def _mapped(size, advice):
    memory = mmap.mmap(-1, size)
    if advice is not None:
        memory.madvise(getattr(mmap, advice))
    array = np.frombuffer(memory, dtype=np.float64)
    begin = time.thread_time()
    array.fill(1.0)
    return (time.thread_time() - begin) / size * 1e9


def _of_arrays(make):
    kept, begin = [], time.thread_time()
    for _ in range(8):
        kept.append(make())
        kept[-1].fill(1.0)
    return (time.thread_time() - begin) / (64 << 20) * 1e9


if __name__ == "__main__":
    main()
