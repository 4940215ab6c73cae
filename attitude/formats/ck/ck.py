"""SPICE C-kernels, written with the frame and clock kernels that they need.

`write` makes three files: x.bc (the C-kernel), x.tf (the frame, of class 3) and x.tsc (a clock of
2^20 ticks a second of TDB from the first epoch, which rounds nothing).  With all three loaded,
``pxform("J2000", name, et)`` is the direction cosine matrix of the motion.  SPICE's J2000 is the
ICRF; its quaternions are those of that matrix, the inverse of body to ICRF; its angular velocities
are rad/s in J2000.

Type 5 is written with subtype 2: Hermite of degree 7 through attitude, rate, angular velocity and
its derivative; type 3 interpolates along great circles.  SPICE takes an epoch as one double of
seconds past J2000, whose spacing is now 1.2e-7 s; at these doubles the kernel is exact.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from attitude.errors import AttitudeError
from attitude.formats.ck import kernel_files
from attitude.formats.ck.attitude import KernelAttitude
from attitude.formats.ck.plan import Plan
from attitude.formats.ck.spice_pool import spiceypy
from attitude.textfiles.atomic_write import made_whole, written_whole

if TYPE_CHECKING:
    from attitude.annotations import EpochOrSeconds, FilePath
    from attitude.motion import HasAttitudes

__all__ = ["KernelAttitude", "Written", "write"]


@dataclass(frozen=True)
class Written:
    """The files that `write` made, and their errors.

    Attributes
    ----------
    kernels : tuple of str
        Names of the C-kernel, the frame kernel and the clock kernel.
    step : float
        Time between records, s.
    error, rate_error : float
        Largest deviations from the motion, rad and rad/s, of the kernel read by SPICE at 2000
        random epochs.
    """

    kernels: tuple[str, str, str]
    step: float
    error: float
    rate_error: float


def write(
    path: FilePath,
    motion: HasAttitudes,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    *,
    t: None = None,
    kind: int = 5,
    tolerance: float = 1e-9,
    rate_tolerance: float | None = None,
    name: str = "TUMBLER",
    instrument: int = -999000,
    clock: int = -999,
    center: int = 399,
) -> Written:
    """Write a motion as a C-kernel, with a step between records that meets the tolerances.

    Parameters
    ----------
    path : str or path
        Ends in .bc; the frame kernel .tf and the clock kernel .tsc are written beside it.
    motion : FreeRotation, AttitudeTable, or anything else with ``.at(t)``
    start, stop : epochs, or TDB seconds since the epoch of the motion
        Both are required.
    t : None
        Refused: the tolerance determines the epochs of the records.
    kind : int
        Type of the C-kernel, 5 or 3.
    tolerance : float
        Largest error of the attitude between records, rad.
    rate_tolerance : float, optional
        Largest error of the angular velocity, rad/s; by default the tolerance times the rate of
        the motion.
    name : str
        Name of the frame.
    instrument, clock, center : int
        NAIF numbers of the frame and its instrument, of the clock, of the center of the frame.

    Returns
    -------
    Written

    Raises
    ------
    AttitudeError
        If the tolerances cannot be reached, a name or number is not one of SPICE's, spiceypy is not
        installed, or a file cannot be written.
    """
    if t is not None or start is None or stop is None:
        raise AttitudeError(
            f"a C-kernel is written from start to stop, at epochs that follow from the tolerance; "
            f"{'t is given' if t is not None else 'start or stop is missing'}: give start= and "
            "stop= (one epoch each), and no t=."
        )
    spiceypy()
    plan = Plan(motion, start, stop, kind, tolerance, rate_tolerance)
    _check_names(path, name, instrument, clock, center)
    stem = os.path.splitext(os.fspath(path))[0]
    frame_kernel, clock_kernel = stem + ".tf", stem + ".tsc"
    numbers = {"name": name, "instrument": instrument, "clock": clock, "center": center}
    with (
        made_whole(path, "the C-kernel") as temporary,
        written_whole(frame_kernel, "the frame kernel") as frames,
        written_whole(clock_kernel, "the clock kernel") as clocks,
    ):
        frames.write(kernel_files.FRAME.format(**numbers))
        clocks.write(kernel_files.CLOCK.format(start=repr(plan.first), minus_clock=-clock))
        for _ in range(4):
            kernel_files.write(temporary, plan, instrument)
            error, rate_error = kernel_files.measured(temporary, plan, instrument)
            if error <= plan.tolerance and rate_error <= plan.rate_tolerance:
                break
            plan.step *= 0.5
            os.unlink(temporary)
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
            raise AttitudeError(f"{what} is {number!r}; give a negative NAIF number.")
    if not (isinstance(center, int) and abs(center) < 2**31):
        raise AttitudeError(f"center is {center!r}; give the NAIF number of a body, 399 for Earth.")
