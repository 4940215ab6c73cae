"""SPICE CK: attitudes for SPICE with the frame and clock kernels they need, and out of any CK.

`write` makes three files: x.bc (the C-kernel), x.tf (the frame, of class 3) and x.tsc (a clock of
2^20 ticks a second of TDB from the first epoch, so that nothing is lost in it).  Load all three,
and ``pxform("J2000", name, et)`` is the direction cosine matrix of the motion.  SPICE's J2000 is
the ICRF; its quaternions are those of that matrix, the inverse of ours, its angular velocities
rad/s in J2000.

Type 5 is written with subtype 2: Hermite of degree 7 through attitude, rate, angular velocity and
its derivative; type 3 goes along great circles.  SPICE takes an epoch as one double of seconds
past J2000, 1.2e-7 s in our days: that is the resolution of the question, the kernel is exact.
"""

import os
from dataclasses import dataclass

from attitude.errors import AttitudeError
from attitude.formats.ck import kernel
from attitude.formats.ck.attitude import KernelAttitude
from attitude.formats.ck.plan import Plan
from attitude.formats.ck.spice_pool import spiceypy
from attitude.textfiles.atomic_write import made_whole, written_whole

__all__ = ["KernelAttitude", "Written", "write"]


@dataclass(frozen=True)
class Written:
    """What `write` made.

    Attributes
    ----------
    kernels : tuple of str
        The C-kernel, the frame kernel and the clock kernel.
    step : float
        Seconds between records.
    error, rate_error : float
        Largest deviations, rad and rad/s, from the motion, of the kernel read by SPICE itself at
        2000 random epochs.
    """

    kernels: tuple
    step: float
    error: float
    rate_error: float


def write(
    path,
    motion,
    start,
    stop,
    *,
    kind=5,
    tolerance=1e-9,
    rate_tolerance=None,
    name="TUMBLER",
    instrument=-999000,
    clock=-999,
    center=399,
):
    """Write a motion as a C-kernel, with records as close as the tolerances want.

    Parameters
    ----------
    path : str or path
        Ends in .bc; the frame kernel .tf and the clock kernel .tsc stand beside it.
    motion : FreeRotation, AttitudeTable, or what else has ``.at(t)``
    start, stop : epochs, or TDB seconds from that of the motion
    kind : int
        5 or 3.
    tolerance : float
        rad, for the attitude between records.
    rate_tolerance : float, optional
        rad/s, for the angular velocity; by default the tolerance times the rate of the motion.
    name : str
        Of the frame.
    instrument, clock, center : int
        NAIF numbers of the frame and its instrument, of the clock, of the center of the frame.

    Returns
    -------
    Written

    Raises
    ------
    AttitudeError
        Where the tolerances cannot be reached, and as other writers.
    """
    spiceypy()
    plan = Plan(motion, start, stop, kind, tolerance, rate_tolerance)
    _check_names(path, name, instrument, clock, center)
    stem = os.path.splitext(os.fspath(path))[0]
    frame_kernel, clock_kernel = stem + ".tf", stem + ".tsc"
    numbers = {"name": name, "instrument": instrument, "clock": clock, "center": center}
    with (
        made_whole(path, "the C-kernel") as aside,
        written_whole(frame_kernel, "the frame kernel") as frames,
        written_whole(clock_kernel, "the clock kernel") as clocks,
    ):
        frames.write(kernel.FRAME.format(**numbers))
        clocks.write(kernel.CLOCK.format(start=repr(plan.first), minus_clock=-clock))
        for _ in range(4):
            kernel.write(aside, plan, instrument)
            error, rate_error = kernel.measured(aside, plan, instrument)
            if error <= plan.tolerance and rate_error <= plan.rate_tolerance:
                break
            plan.step *= 0.5
            os.unlink(aside)
        else:
            raise AttitudeError(
                f"the kernel deviates by {error:.2g} rad and {rate_error:.2g} rad/s from the "
                f"motion at steps of {plan.step:.3g} s, more than the tolerances {tolerance:g} rad "
                f"and {plan.rate_tolerance:.3g} rad/s; give larger ones."
            )
    made = (os.fspath(path), frame_kernel, clock_kernel)
    return Written(made, plan.step, error, rate_error)


def _check_names(path, name, instrument, clock, center):
    if not os.fspath(path).endswith(".bc"):
        raise AttitudeError(f"{os.fspath(path)!r} does not end in .bc, as C-kernels do.")
    if not (isinstance(name, str) and name.isidentifier() and len(name) <= 26):
        raise AttitudeError(f"name is {name!r}; give a frame name of letters, digits and _.")
    for what, number in (("instrument", instrument), ("clock", clock)):
        if not (isinstance(number, int) and -(2**31) < number < 0):
            raise AttitudeError(f"{what} is {number!r}; NAIF numbers of these are negative.")
    if not (isinstance(center, int) and abs(center) < 2**31):
        raise AttitudeError(f"center is {center!r}; give the NAIF number of a body, 399 for Earth.")
