"""The files of a C-kernel: segments written by SPICE, texts of the frame and clock kernels."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.formats.ck import daf_head
from attitude.formats.ck.plan import DEGREE, apart, longest
from attitude.formats.ck.spice_pool import spiceypy

if TYPE_CHECKING:
    from collections.abc import Iterator

    from attitude.annotations import FloatArray
    from attitude.formats.ck.clock import KernelClock
    from attitude.formats.ck.plan import Plan

REFERENCE: str = "J2000"
# Records of a segment; and records of each neighbour that it repeats, so that the windows of
# interpolation are centered up to its ends.
_PIECE, _PAD = 50_000, 8
# Random epochs at which the finished kernel is read.
_CHECKS = 2000


@contextmanager
def opened(path: str) -> Iterator[tuple[Any, int]]:
    """SPICE and the handle of a new C-kernel, which is closed at the end of the block.

    Raises
    ------
    AttitudeError
        For errors of SPICE, and if the disk is full; the file is closed and can be deleted.
    """
    spice = spiceypy()
    handle = None
    try:
        handle = spice.ckopn(path, "attitude", 0)
        yield spice, handle
        spice.ckcls(handle)
        # SPICE does not notice a full disk.
        if broken := daf_head.fault(path):
            raise cannot(f"the C-kernel is not whole: {broken}.")
    except spice.exceptions.SpiceyError as err:
        spice.reset()
        if handle is not None:
            with suppress(spice.exceptions.SpiceyError):
                spice.dafcls(handle)
            spice.reset()
        raise cannot(f"SPICE cannot write the C-kernel ({err.short}).") from err


def write(path: str, plan: Plan, clock: KernelClock, instrument: int) -> None:
    """Write the C-kernel of a `Plan` to a new file.

    Parameters
    ----------
    path : str
        Must not exist.
    plan : Plan
    clock : KernelClock
    instrument : int
        NAIF number.

    Raises
    ------
    AttitudeError
        As `opened`.
    """
    stretches = plan.records()
    with opened(path) as (spice, handle):
        for number, seconds in enumerate(stretches):
            for start in range(0, max(len(seconds) - 1, 1), _PIECE):
                _write_segment(spice, handle, plan, clock, instrument, number, seconds, start)


def cannot(sentence: str) -> AttitudeError:
    """The error for a kernel that cannot be written."""
    return AttitudeError(f"{sentence} Is the disk full? Give a file in a folder with free space.")


def _write_segment(spice, handle, plan, clock, instrument, number, seconds, start):
    stop = min(start + _PIECE, len(seconds) - 1)
    pad = _PAD if plan.kind == 5 else 0
    part = slice(max(start - pad, 0), stop + 1 + pad)
    history = plan.history(seconds[part], number)
    ticks = clock.ticks(seconds[part])
    ends = float(ticks[start - part.start]), float(ticks[stop - part.start])
    frames = instrument, REFERENCE, True
    if plan.kind == 5:
        packets = _packets(history, plan.speed(seconds[part])[:, None])
        spice.ckw05(
            *(handle, 2, DEGREE, *ends, *frames, "attitude", ticks, packets),
            *(clock.per_tick, 1, ticks[:1]),
        )
    else:
        quats = np.ascontiguousarray(quaternion.conjugate(history.wxyz))
        rates = np.ascontiguousarray(history.angular_velocity_inertial)
        spice.ckw03(
            *(handle, *ends, *frames, "attitude", len(ticks), ticks, quats, rates),
            *(1, ticks[:1]),
        )


def _packets(history, speed):
    """Subtype 2 of type 5: quaternion, its rate, angular velocity in J2000, its rate.

    `speed` (N, 1) are seconds of TDB in a second of the clock, in which SPICE differentiates.
    """
    return np.concatenate(
        [
            quaternion.conjugate(history.wxyz),
            quaternion.conjugate(
                speed * forms.quaternion_rate(history.wxyz, history.angular_velocity)
            ),
            history.angular_velocity_inertial,
            # d/dt of R w is R w', since w x w vanishes
            speed * quaternion.rotate(history.wxyz, history.angular_acceleration),
        ],
        axis=1,
    )


def measured(path: str, plan: Plan, clock: KernelClock, instrument: int) -> tuple[float, float]:
    """Largest deviations from the motion, rad and rad/s, of the C-kernel read by SPICE.

    They are measured at 2000 random epochs, and at four beside each jump of the angular velocity,
    of at most 2000.

    Raises
    ------
    AttitudeError
        If SPICE cannot read the kernel.
    """
    random = np.random.default_rng(2006)
    et = plan.first + plan.checks(_CHECKS, random)
    # Doubles of the clock's time scale: on the clock they are exact.
    seconds = np.clip(et - plan.first, plan.begin, plan.end)
    true = plan.history(seconds)
    matrices, rates = measured_at(path, clock.ticks(seconds), instrument)
    error = apart(forms.from_dcm(matrices), true.wxyz)
    return error, longest(rates - true.angular_velocity_inertial)


def measured_at(
    path: str, ticks: FloatArray, instrument: int, *, rates: bool = True
) -> tuple[FloatArray, FloatArray]:
    """Matrices (N, 3, 3) and angular velocities (N, 3) in J2000 that SPICE reads at clock times.

    The kernel is read by its handle, so that the user's kernels in SPICE's pool are neither used
    nor changed.  Without rates they are NaN.

    Raises
    ------
    AttitudeError
        If SPICE cannot read the kernel.
    """
    spice = spiceypy()
    matrices, found = np.empty((len(ticks), 3, 3)), np.full((len(ticks), 3), np.nan)
    handle = None
    try:
        handle = spice.cklpf(path)
        for k, tick in enumerate(ticks.tolist()):
            if rates:
                matrices[k], found[k], _ = spice.ckgpav(instrument, tick, 0.0, REFERENCE)
            else:
                matrices[k], _ = spice.ckgp(instrument, tick, 0.0, REFERENCE)
    except (spice.exceptions.SpiceyError, spice.exceptions.NotFoundError) as err:
        spice.reset()
        raise cannot(
            f"SPICE cannot read the kernel it has written ({getattr(err, 'short', 'not found')})."
        ) from err
    finally:
        if handle is not None:
            spice.ckupf(handle)
    return matrices, found


# Text of the frame kernel, with name, instrument, clock and center to be filled in.
FRAME: str = """\
KPL/FK

The frame of a body whose attitude is in the C-kernel of the same name.

\\begindata
FRAME_{name} = {instrument}
FRAME_{instrument}_NAME = '{name}'
FRAME_{instrument}_CLASS = 3
FRAME_{instrument}_CLASS_ID = {instrument}
FRAME_{instrument}_CENTER = {center}
CK_{instrument}_SCLK = {clock}
CK_{instrument}_SPK = {center}
\\begintext
"""

# Text of the clock kernel, with minus_clock, start (s past J2000), the number and the name of its
# time scale to be filled in.
CLOCK: str = """\
KPL/SCLK

A clock of 2^20 ticks a second of {scale} from the first epoch of the C-kernel of the same name.

\\begindata
SCLK_KERNEL_ID = ( @2026-01-01 )
SCLK_DATA_TYPE_{minus_clock} = ( 1 )
SCLK01_TIME_SYSTEM_{minus_clock} = ( {system} )
SCLK01_N_FIELDS_{minus_clock} = ( 2 )
SCLK01_MODULI_{minus_clock} = ( 10000000000 1048576 )
SCLK01_OFFSETS_{minus_clock} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{minus_clock} = ( 1 )
SCLK_PARTITION_START_{minus_clock} = ( 0.0 )
SCLK_PARTITION_END_{minus_clock} = ( 1.0E15 )
SCLK01_COEFFICIENTS_{minus_clock} = ( 0.0 {start} 1.0 )
\\begintext
"""
