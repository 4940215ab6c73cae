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

import math
import os
from dataclasses import dataclass

import numpy as np

from attitude import epochs, interpolation, quaternion, tdb
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.formats.aside import made_whole, written_whole
from attitude.frozen import Frozen
from attitude.history import AttitudeHistory

# A power of two: doubles of seconds become ticks, and back, without rounding.
_TICKS = 2.0**20  # a second
_DEGREE = 7
_REFERENCE = "J2000"
# Records of one segment, and of its neighbours that it holds too, so that the windows of
# interpolation are centered up to its ends.
_PIECE, _PAD = 50_000, 8
_MOST_RECORDS = 20_000_000
# Where the error of interpolation is measured before, and of the finished kernel after.
_PROBES, _CHECKS = 300, 2000
_MARGIN, _ASIDE = 0.25, 0.25


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
    spice = _spiceypy()
    plan = _Plan(motion, start, stop, kind, tolerance, rate_tolerance)
    _check_names(path, name, instrument, clock)
    stem = os.path.splitext(os.fspath(path))[0]
    frame_kernel, clock_kernel = stem + ".tf", stem + ".tsc"
    numbers = {"name": name, "instrument": int(instrument), "clock": int(clock), "center": center}
    with (
        made_whole(path, "the C-kernel") as aside,
        written_whole(frame_kernel, "the frame kernel") as frames,
        written_whole(clock_kernel, "the clock kernel") as clocks,
    ):
        frames.write(_FRAME.format(**numbers))
        clocks.write(_CLOCK.format(start=repr(plan.first), minus_clock=-clock))
        for each in (frames, clocks):
            each.flush()
        texts = (frames.name, clocks.name)
        for _ in range(4):
            _write_kernel(spice, aside, plan, numbers)
            error, rate_error = _measured(spice, (aside, *texts), plan, numbers)
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


class _Plan:
    """The span of a kernel on its own clock, the motion on it, and the step between records."""

    def __init__(self, motion, start, stop, kind, tolerance, rate_tolerance):
        if kind not in (3, 5):
            raise AttitudeError(f"kind is {kind!r}; CK is written in types 3 and 5.")
        if not (isinstance(tolerance, (int, float)) and 1e-14 <= tolerance <= 1.0):
            raise AttitudeError(f"tolerance is {tolerance!r}; give a number of rad, 1e-14 to 1.")
        self.kind, self.tolerance, self._motion = kind, float(tolerance), motion
        epoch = motion.at(np.zeros(0)).epoch if not hasattr(motion, "span") else motion.epoch
        ends = [epochs.seconds_since(epoch, value) for value in (start, stop)]
        ends = [tdb.add((hi, 0.0), 0.0 if lo is None else lo) for hi, lo in ends]
        # The clock starts at an epoch that is one double of TDB, not after the start.
        first, rest = tdb.add(ends[0], epoch.seconds, epoch.low)
        self.first = float(first if rest >= 0.0 else np.nextafter(first, -np.inf))
        self._shift = tdb.add((self.first, 0.0), -epoch.seconds, -epoch.low)
        begin, end = (tdb.add(pair, -self._shift[0], -self._shift[1])[0] for pair in ends)
        self.begin, self.end = float(begin), float(end)
        if not self.end > self.begin:
            raise AttitudeError("stop is not after start; give a span of time.")
        probes = self.history(np.linspace(self.begin, self.end, _PROBES)).angular_velocity
        fastest = float(np.max(np.linalg.norm(probes, axis=1)))
        if rate_tolerance is None:
            rate_tolerance = self.tolerance * max(fastest, 1e-12)
        if not rate_tolerance > 0.0:
            raise AttitudeError(f"rate_tolerance is {rate_tolerance!r}; give rad/s above zero.")
        self.rate_tolerance = float(rate_tolerance)
        self.step = self._first_step(fastest)

    def history(self, seconds):
        """The motion at seconds of the clock, exactly."""
        return self._motion.at(*tdb.add((seconds, 0.0), *self._shift))

    def records(self):
        """The seconds of all records: the step, a little less so that the last is the end."""
        count = max(math.ceil((self.end - self.begin) / self.step) + 1, 2)
        if count > _MOST_RECORDS:
            raise AttitudeError(
                f"the tolerances want {count} records, more than {_MOST_RECORDS}; give larger "
                "ones, a shorter span, or type 5."
            )
        return np.linspace(self.begin, self.end, count)

    def _first_step(self, fastest):
        """A step at which the error between records is a quarter of the tolerances."""
        span = self.end - self.begin
        # SPICE takes quaternions more than 90 deg apart for a mistake of sign.
        longest = min(span, 1.0 / fastest) if fastest > 0.0 else span
        step = 0.5 * longest
        order = 2.0 if self.kind == 3 else _DEGREE + 1.0
        for _ in range(4):
            step = min(step, longest)
            errors = self._errors(step)
            worst = max(errors[0] / self.tolerance, errors[1] / self.rate_tolerance)
            step *= min((_MARGIN / max(worst, 1e-30)) ** (1.0 / order), 4.0)
        return min(step, longest)

    def _errors(self, step):
        """Largest errors of attitude and rate between records so far apart, at some places."""
        width = 2 if self.kind == 3 else (_DEGREE + 1) // 2
        room = (width - 1) * step
        first = self.begin + np.linspace(0.0, 1.0, _PROBES) * max(self.end - self.begin - room, 0.0)
        place = np.arange(width) * step
        t = first[:, None] + place
        t = np.minimum(t, self.end) if room > self.end - self.begin else t
        nodes = self.history(t)
        # Not in the middle, where the error of a steady rotation is one of length alone.
        middle = first + (0.5 * (width - 1) + _ASIDE) * step
        middle = np.minimum(middle, self.end)
        true = self.history(middle)
        q = [nodes.wxyz[:, k] for k in range(width)]
        w = [nodes.angular_velocity_inertial[:, k] for k in range(width)]
        if self.kind == 3:
            turn = quaternion.multiply(quaternion.conjugate(q[0]), q[1])
            part = forms.from_rotation_vector((0.5 + _ASIDE) * forms.to_rotation_vector(turn))
            rates = w[0] + (0.5 + _ASIDE) * (w[1] - w[0])
            found = quaternion.multiply(q[0], part), rates
        else:
            at = np.broadcast_to(place / step, (len(first), width))
            x = (middle - first) / step
            bends = quaternion.rotate(nodes.wxyz, nodes.angular_acceleration)
            change = forms.quaternion_rate(nodes.wxyz, nodes.angular_velocity)
            slopes = [[part[:, k] * step for k in range(width)] for part in (change, bends)]
            found = [
                interpolation.polynomial(at, values, slope, x)
                for values, slope in zip((q, w), slopes, strict=True)
            ]
        return _apart(forms.unit(found[0]), true.wxyz), _longest(
            found[1] - true.angular_velocity_inertial
        )


def _write_kernel(spice, path, plan, numbers):
    seconds = plan.records()
    frames = numbers["instrument"], _REFERENCE, True
    try:
        handle = spice.ckopn(path, "attitude", 0)
        for start in range(0, max(len(seconds) - 1, 1), _PIECE):
            stop = min(start + _PIECE, len(seconds) - 1)
            pad = _PAD if plan.kind == 5 else 0
            part = slice(max(start - pad, 0), stop + 1 + pad)
            history = plan.history(seconds[part])
            ticks = seconds[part] * _TICKS
            ends = float(seconds[start] * _TICKS), float(seconds[stop] * _TICKS)
            if plan.kind == 5:
                packets = _packets(history)
                spice.ckw05(
                    *(handle, 2, _DEGREE, *ends, *frames, "attitude", ticks, packets),
                    *(1.0 / _TICKS, 1, ticks[:1]),
                )
            else:
                quats = np.ascontiguousarray(quaternion.conjugate(history.wxyz))
                rates = np.ascontiguousarray(history.angular_velocity_inertial)
                spice.ckw03(
                    *(handle, *ends, *frames, "attitude", len(ticks), ticks, quats, rates),
                    *(1, ticks[:1]),
                )
        spice.ckcls(handle)
    except spice.exceptions.SpiceyError as err:
        spice.reset()
        raise AttitudeError(f"SPICE cannot write the kernel ({err.short}: {err.long}).") from err


def _packets(history):
    """Subtype 2 of type 5: quaternion, its rate, angular velocity in J2000, its rate."""
    return np.concatenate(
        [
            quaternion.conjugate(history.wxyz),
            quaternion.conjugate(forms.quaternion_rate(history.wxyz, history.angular_velocity)),
            history.angular_velocity_inertial,
            # d/dt of R w is R w', since w x w vanishes
            quaternion.rotate(history.wxyz, history.angular_acceleration),
        ],
        axis=1,
    )


def _measured(spice, kernels, plan, numbers):
    """Largest deviations, rad and rad/s, of the kernels read by SPICE, at random epochs."""
    random = np.random.default_rng(2006)
    et = plan.first + random.uniform(plan.begin, plan.end, _CHECKS)
    seconds = et - plan.first
    true = plan.history(np.clip(seconds, plan.begin, plan.end))
    matrices, rates = np.empty((_CHECKS, 3, 3)), np.empty((_CHECKS, 3))
    try:
        for kernel in kernels:
            spice.furnsh(kernel)
        for k, second in enumerate(np.clip(seconds, plan.begin, plan.end)):
            ticks = second * _TICKS
            matrices[k], rates[k], _ = spice.ckgpav(numbers["instrument"], ticks, 0.0, _REFERENCE)
    except (spice.exceptions.SpiceyError, spice.exceptions.NotFoundError) as err:
        spice.reset()
        raise AttitudeError(f"SPICE cannot read the kernel it has written ({err}).") from err
    finally:
        for kernel in kernels:
            spice.unload(kernel)
    error = _apart(forms.from_dcm(matrices), true.wxyz)
    return error, _longest(rates - true.angular_velocity_inertial)


def _apart(p, q):
    """The largest angle in rad between attitudes."""
    return float(
        np.max(forms.to_axis_angle(quaternion.multiply(quaternion.conjugate(p), q))[1], initial=0.0)
    )


def _longest(vectors):
    return float(np.max(np.linalg.norm(vectors, axis=-1), initial=0.0))


def _check_names(path, name, instrument, clock):
    if not os.fspath(path).endswith(".bc"):
        raise AttitudeError(f"{os.fspath(path)!r} does not end in .bc, as C-kernels do.")
    if not (isinstance(name, str) and name.isidentifier() and len(name) <= 26):
        raise AttitudeError(f"name is {name!r}; give a frame name of letters, digits and _.")
    for what, number in (("instrument", instrument), ("clock", clock)):
        if not (isinstance(number, int) and -(2**31) < number < 0):
            raise AttitudeError(f"{what} is {number!r}; NAIF numbers of these are negative.")


def _spiceypy():
    try:
        import spiceypy
    except ImportError as err:
        raise AttitudeError(
            'CK needs SPICE; install it with pip install "attitude-propagation[spice]".'
        ) from err
    return spiceypy


_FRAME = """\
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

_CLOCK = """\
KPL/SCLK

A clock of 2^20 ticks a second of TDB from the first epoch of the C-kernel of the same name.

\\begindata
SCLK_KERNEL_ID = ( @2026-01-01 )
SCLK_DATA_TYPE_{minus_clock} = ( 1 )
SCLK01_TIME_SYSTEM_{minus_clock} = ( 1 )
SCLK01_N_FIELDS_{minus_clock} = ( 2 )
SCLK01_MODULI_{minus_clock} = ( 10000000000 1048576 )
SCLK01_OFFSETS_{minus_clock} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{minus_clock} = ( 1 )
SCLK_PARTITION_START_{minus_clock} = ( 0.0 )
SCLK_PARTITION_END_{minus_clock} = ( 1.0E15 )
SCLK01_COEFFICIENTS_{minus_clock} = ( 0.0 {start} 1.0 )
\\begintext
"""


# Reading ------------------------------------------------------------------------------------------


class KernelAttitude(Frozen):
    """The attitude of a frame that SPICE knows, from any C-kernel (or other kernel with frames).

    Parameters
    ----------
    kernels : path or list of them
        All that the frame needs: CK, FK, SCLK, and leap seconds where the clock wants them.  They
        are loaded into SPICE's pool until `close`, or the end of a ``with`` block.
    frame : str
        By its name.

    Attributes
    ----------
    epoch : Instant
        J2000 (TDB), from which plain numbers of t are counted.

    Notes
    -----
    SPICE takes one double of seconds past J2000, 1.2e-7 s; what that leaves out is added along
    the angular velocity.  One epoch at a time: some 10 microseconds each.  Not for threads.
    """

    def __init__(self, kernels, frame):
        spice = _spiceypy()
        names = [kernels] if isinstance(kernels, (str, os.PathLike)) else list(kernels)
        names = tuple(os.fspath(name) for name in names)
        self._set("kernels", names)
        self._set("frame", frame)
        self._set("epoch", epochs.Instant(0.0))
        loaded = []
        try:
            for name in names:
                spice.furnsh(name)
                loaded.append(name)
            if not isinstance(frame, str) or spice.namfrm(frame) == 0:
                raise AttitudeError(
                    f"frame is {frame!r}, which the kernels {', '.join(names)} do not define; give "
                    "the name of a frame, and its frame kernel."
                )
        except spice.exceptions.SpiceyError as err:
            spice.reset()
            for name in loaded:
                spice.unload(name)
            raise AttitudeError(f"SPICE cannot load {name}: {err.short}.") from err
        except AttitudeError:
            for name in loaded:
                spice.unload(name)
            raise

    def close(self):
        """Unload the kernels."""
        for name in self.kernels:
            _spiceypy().unload(name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def at(self, t, low=None):
        """The attitudes at some epochs, as of `FreeRotation.at`.

        Raises
        ------
        AttitudeError
            For epochs at which the kernels have no attitude.
        """
        seconds, low = epochs.seconds_since(self.epoch, t, low)
        wxyz, _ = self._evaluate(seconds, low)
        low = None if low is None else np.array(low)
        return AttitudeHistory(self, self.epoch, np.array(seconds), low, wxyz)

    def angular_velocity_at(self, seconds, low=None):
        """Angular velocity (..., 3), rad/s in body axes, at TDB seconds past J2000."""
        return self._evaluate(np.asarray(seconds, dtype=np.float64), low)[1]

    def angular_acceleration_from(self, angular_velocity):
        """Not known: a kernel has no inertia."""
        raise AttitudeError(
            "a kernel has no moments of inertia, from which angular velocities would give "
            "accelerations; make an AttitudeTable of it, or fit a FreeRotation."
        )

    def _evaluate(self, seconds, low):
        spice = _spiceypy()
        hi = np.ravel(seconds)
        rest = np.zeros(hi.size) if low is None else np.ravel(np.broadcast_to(low, seconds.shape))
        matrices, rates = np.full((hi.size, 3, 3), np.eye(3)), np.full((hi.size, 3), np.nan)
        for k, second in enumerate(hi.tolist()):
            if math.isnan(second):
                continue
            try:
                both = spice.sxform(_REFERENCE, self.frame, second)
                matrices[k], rates[k] = spice.xf2rav(both)
            except spice.exceptions.SpiceyError as err:
                spice.reset()
                where = self.epoch.after(second) if math.isfinite(second) else second
                raise AttitudeError(
                    f"the kernels have no attitude of {self.frame} at {where} ({err.short}); ask "
                    "within their coverage (SPICE's ckbrief lists it)."
                ) from err
        wxyz = forms.continuous(forms.from_dcm(matrices))
        omega = quaternion.rotate(quaternion.conjugate(wxyz), rates)
        turned = forms.from_rotation_vector(np.where(np.isnan(omega), 0.0, omega) * rest[:, None])
        wxyz = quaternion.multiply(wxyz, turned)
        wxyz[np.isnan(hi)] = np.nan
        shape = np.shape(seconds)
        return wxyz.reshape(*shape, 4), omega.reshape(*shape, 3)
