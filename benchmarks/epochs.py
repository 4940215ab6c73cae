"""What does the conversion of UTC epochs to TDB cost, and how far is it from astropy's?

It prints, for 1e5 UTC epochs as one astropy Time over a day, a year and a century, the time per
epoch of `seconds_since` (the first call, which fits the pieces of TDB - TT, and later ones), the
time per epoch of astropy's own `.tdb`, and the largest difference between the two.

    python benchmarks/epochs.py
"""

import time
import warnings

import astropy
import erfa
import numpy as np
from astropy.time import Time

from attitude import epochs
from attitude._compilation.choice import compiling
from attitude._support import pairs
from attitude.epochs import _time_scales

COUNT = 100_000


def nanoseconds(function):
    """The result of a call and its time divided by the number of epochs, in ns."""
    begin = time.perf_counter()
    result = function()
    return result, (time.perf_counter() - begin) / COUNT * 1e9


def difference(start, times, hi, lo):
    """The largest difference from astropy's TDB, in s; computed in two doubles."""
    reference = _time_scales.seconds_from_jd(times.jd1, times.jd2)
    reference = pairs.add(reference, -start.seconds, -start.low)
    return np.max(np.abs((hi - reference[0]) + (lo - reference[1])))


def main():
    warnings.simplefilter("ignore", erfa.ErfaWarning)  # "dubious year", from astropy
    print(f"numpy {np.__version__}, astropy {astropy.__version__}, {COUNT} UTC epochs as one Time")
    print("span        first call    later      astropy   ns an epoch;   largest difference, s")
    start = epochs.instant("2020-01-01T00:00:00")
    # Import everything, and let numpy allocate this much memory once, before measuring.
    epochs.seconds_since(start, Time(1980.0 + np.linspace(0.0, 1.0, COUNT), format="jyear"))
    for label, days in (("a day", 1.0), ("a year", 365.25), ("a century", 36525.0)):
        utc = Time(2458849.5, np.linspace(0.0, days, COUNT), format="jd", scale="utc")
        _time_scales._pieces.clear()
        _, first = nanoseconds(lambda utc=utc: epochs.seconds_since(start, utc))
        later = min(
            nanoseconds(lambda utc=utc: epochs.seconds_since(start, utc))[1] for _ in range(5)
        )
        hi, lo = epochs.seconds_since(start, utc)
        reference, theirs = nanoseconds(lambda utc=utc: utc.tdb)
        error = difference(start, reference, hi, lo)
        print(f"{label:10s} {first:11.0f} {later:8.0f} {theirs:12.0f} {error:30.1e}")


if __name__ == "__main__":
    with compiling():
        main()
