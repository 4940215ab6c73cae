"""SPICE C-kernels, written with the frame and clock kernels that they need.

`write` makes three files: x.bc (the C-kernel), x.tf (the frame, of class 3) and x.tsc (a clock of
2^20 ticks a second of TDB from the first epoch, which rounds nothing).  With all three loaded,
``pxform("J2000", name, et)`` is the direction cosine matrix of the motion.  SPICE's J2000 is the
ICRF; its quaternions are those of that matrix, the inverse of body to ICRF; its angular velocities
are rad/s in J2000.

Type 5 is written with subtype 2: Hermite of degree 7 through attitude, rate, angular velocity and
its derivative; type 3 interpolates along great circles.  SPICE takes an epoch as one double of
seconds past J2000, whose spacing is now 1.2e-7 s; at these doubles the kernel is exact.

TDB of SPICE is TT + 1.657 ms sin E by one term; that of ERFA, which this package uses, has 787
terms and differs by up to 30 microseconds: 3e-6 rad at 0.1 rad/s.  ``time_scale="spice"`` makes a
kernel that is right at the epochs that SPICE makes of dates in UTC.
"""

from __future__ import annotations

import math
import os
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial, wraps
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude._textfiles.atomic_write import made_whole, written_whole
from attitude._textfiles.lines import path_text
from attitude.epochs import _instants
from attitude.errors import AttitudeError
from attitude.formats import _ck_files
from attitude.formats._ck_files import REFERENCE, LoadedKernels, Plan, TableSegments, spiceypy
from attitude.formats._format import Format, OpenedFile, Option, refuse_foreign, register
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._motion import Motion
from attitude.motions._table import AttitudeTable

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from typing import NoReturn

    from numpy.typing import ArrayLike

    from attitude._support.annotations import EpochOrSeconds, FilePath, FloatArray
    from attitude.motions._motion import HasAttitudes

__all__ = ["KernelAttitude", "Written", "write"]


# ---- The attitude of a frame from any C-kernel, through SPICE


class KernelAttitude(Motion):
    """The attitude of a frame that SPICE knows, from any C-kernel (or other kernel with frames).

    Parameters
    ----------
    kernels : path or list of paths
        All kernels that the frame needs: CK, FK, SCLK, and leap seconds if the clock needs them.
        They are loaded in SPICE's pool until `close`, or the end of a ``with`` block.
    frame : str
        Name of the frame.

    Attributes
    ----------
    epoch : Instant
        J2000 (TDB), from which plain numbers of t are counted.
    kernels : tuple of str
        Names of the kernels.
    frame : str
        As given.

    Raises
    ------
    AttitudeError
        If spiceypy is not installed, SPICE cannot load a kernel, or the frame is not defined.

    Notes
    -----
    SPICE takes an epoch as one double of seconds past J2000, whose spacing is 1.2e-7 s; the rest of
    an epoch is added along the angular velocity, if the kernels have one.  An epoch takes some 10
    microseconds.  SPICE is not thread-safe.
    """

    kernels: tuple[str, ...]
    frame: str
    _loaded: LoadedKernels

    def __init__(self, kernels: FilePath | Iterable[FilePath], frame: str):
        names: list[FilePath]
        names = [kernels] if isinstance(kernels, (str, os.PathLike)) else list(kernels)
        loaded = LoadedKernels(names)
        if not isinstance(frame, str) or spiceypy().namfrm(frame) == 0:
            held = ", ".join(dict.fromkeys(_frames_of(names)))
            loaded.close()
            listed = ", ".join(os.fspath(name) for name in names)
            raise AttitudeError(
                f"frame is {frame!r}, which the kernels {listed or '(none)'} do not define; give "
                f"the name of a frame{f', such as {held}' if held else ''}, and its frame kernel "
                "(on the command line --body, --kernels)."
            )
        self._set("kernels", tuple(os.fspath(name) for name in names))
        self._set("frame", frame)
        self._set("epoch", _instants.J2000)
        self._set("_loaded", loaded)

    def close(self) -> None:
        """Unload these kernels, and no others; a second call does nothing."""
        self._loaded.close()

    def angular_acceleration_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        angular_velocity: FloatArray | None = None,
    ) -> NoReturn:
        """AttitudeError: a kernel has no inertia, from which accelerations would follow."""
        raise AttitudeError(
            "a kernel has no moments of inertia, from which angular velocities would give "
            "accelerations; make an AttitudeTable of it, or fit a FreeRotation."
        )

    def has_rates_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> bool:
        """Whether the kernels hold angular velocities at all these TDB seconds since J2000."""
        seconds = np.asarray(seconds, dtype=np.float64)
        return not np.any(np.isnan(self._read(seconds, low)[1]))

    def _evaluate(self, seconds, low, order):
        wxyz, rates = self._read(seconds, low)
        if not order:
            return [wxyz]
        if np.any(np.isnan(rates[~np.isnan(seconds)])):
            raise AttitudeError(
                f"the kernels have attitudes of {self.frame}, but no angular velocities; make an "
                "AttitudeTable of the attitudes, which differentiates them."
            )
        return [wxyz, rates]

    def _read(self, seconds, low):
        """Attitudes, and rates over the body axes, NaN where the kernels have none."""
        hi, shape = np.ravel(seconds), np.shape(seconds)
        extra = np.zeros(shape) if low is None else np.array(np.broadcast_to(low, shape))
        extra = extra.ravel()
        matrices, rates = np.full((hi.size, 3, 3), np.eye(3)), np.full((hi.size, 3), np.nan)
        for k, second in enumerate(hi.tolist()):
            if not math.isnan(second):
                matrices[k], rates[k], evaluated = self._state_at(second)
                extra[k] += second - evaluated
        wxyz = forms.continuous(forms.from_dcm(matrices))
        omega = quaternion.rotate(quaternion.conjugate(wxyz), rates)
        turned = forms.from_rotation_vector(np.where(np.isnan(omega), 0.0, omega) * extra[:, None])
        wxyz = quaternion.multiply(wxyz, turned)
        wxyz[np.isnan(hi)] = np.nan
        return wxyz.reshape(*shape, 4), omega.reshape(*shape, 3)

    def _state_at(self, second):
        """Direction cosine matrix and angular velocity in J2000, and their epoch, s past J2000."""
        spice = spiceypy()
        ways = (
            lambda t: spice.xf2rav(spice.sxform(REFERENCE, self.frame, t)),
            lambda t: (spice.pxform(REFERENCE, self.frame, t), np.nan),  # no angular velocities
        )
        for t in (second, math.nextafter(second, math.inf), math.nextafter(second, -math.inf)):
            for way in ways:
                try:
                    return *way(t), t
                except spice.exceptions.SpiceyError as err:
                    spice.reset()
                    reason = err
        where = f"{self.epoch.after(second).utc_iso} UTC" if math.isfinite(second) else second
        raise AttitudeError(
            f"the kernels have no attitude of {self.frame} at {where} ({reason.short}); give "
            "epochs within their coverage (SPICE's ckbrief lists it), and kernels of the frames "
            "that it is relative to, as the spacecraft's (on the command line --kernels)."
        ) from reason


def _frames_of(names):
    """The frames of the C-kernels among loaded kernels, as far as these define them."""
    spice = spiceypy()
    for name in names:
        try:
            numbers = list(spice.ckobj(os.fspath(name)))
        except spice.exceptions.SpiceyError:  # no C-kernel
            spice.reset()
            continue
        for number in numbers:
            with suppress(spice.exceptions.NotFoundError):
                yield spice.ccifrm(3, number)[1]


@dataclass(frozen=True)
class Written:
    """The files that `write` made, and their errors.

    Attributes
    ----------
    kernels : tuple of str
        Names of the C-kernel, the frame kernel and the clock kernel (and those given with it).
    step : float
        Time between records, s; the greatest of a table.
    error, rate_error : float
        Largest deviations from the motion, rad and rad/s, of the kernel read by SPICE at 2000
        random epochs.
    """

    kernels: tuple[str, ...]
    step: float
    error: float
    rate_error: float

    def __str__(self) -> str:
        names = ", ".join(os.path.basename(name) for name in self.kernels)
        return f"{names}: error {self.error:.2g} rad"


def write(
    path: FilePath,
    motion: HasAttitudes | str,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    *,
    t: None = None,
    kind: int = 5,
    tolerance: float = 1e-9,
    rate_tolerance: float | None = None,
    name: str = "TUMBLER",
    instrument: int = -999000,
    clock: int | FilePath | Sequence[FilePath] = -999,
    frame_kernel: FilePath | None = None,
    center: int = 399,
    time_scale: str = "tdb",
) -> Written:
    """Write a motion as a C-kernel, with a step between records that meets the tolerances.

    Parameters
    ----------
    path : str or path
        Ends in .bc; the frame kernel .tf and the clock kernel .tsc are written beside it.
    motion : FreeRotation, AttitudeTable, name in the catalogue, or anything else with ``.at(t)``
    start, stop : epochs, or TDB seconds since the epoch of the motion
        Both are required, but for a table: without both its records are written as they are, a
        segment for each stretch without gaps (see `_ck_files.TableSegments`).
    t : None
        Refused: the tolerance determines the epochs of the records.
    kind : int
        Type of the C-kernel, 5 or 3.
    tolerance : float
        Largest error of the attitude between records, rad; from a table, for its records too.
    rate_tolerance : float, optional
        Largest error of the angular velocity, rad/s; by default the tolerance times the rate of
        the motion.
    name : str
        Name of the frame.
    instrument, center : int
        NAIF numbers of the frame and its instrument, of the center of the frame.
    clock : int, path or list of paths
        NAIF number of the clock that is written, or the clock kernel of a mission, with its leap
        seconds if it needs them: then no clock is written, and epochs are good to one double of
        TDB, 1.2e-7 s.
    frame_kernel : path, optional
        A frame kernel of the mission that defines the frame `name` of class 3; then none is
        written, and `instrument` is that of the frame.
    time_scale : str
        "tdb": the kernel is exact at TDB as ERFA computes it; "spice": at what SPICE's own formula
        makes of a date in UTC (`str2et`), up to 30 microseconds away, with leap seconds loaded.

    Returns
    -------
    Written

    Raises
    ------
    AttitudeError
        If the tolerances cannot be reached, a name or number is not one of SPICE's, spiceypy is not
        installed, or a file cannot be written.
    """
    refuse_foreign(path, "ck")
    of_records = isinstance(motion, AttitudeTable) and start is None and stop is None
    if t is not None or ((start is None or stop is None) and not of_records):
        raise AttitudeError(
            f"a C-kernel is written from start to stop, at epochs that follow from the tolerance; "
            f"{'t is given' if t is not None else 'start or stop is missing'}: give start= and "
            "stop= (one epoch each), and no t=."
        )
    validation.one_of(time_scale, "time_scale", ("tdb", "spice"))
    of_mission, of_spice = not isinstance(clock, int), time_scale == "spice"
    if of_spice and (of_mission or of_records):
        raise AttitudeError(
            'time_scale="spice" is for the clock that is written beside a kernel of a motion; '
            "leave clock= out, and give start= and stop=."
        )
    spiceypy()
    scale = "tt" if of_spice else "tdb"
    plan: Plan | TableSegments
    if start is None or stop is None:
        assert isinstance(motion, AttitudeTable)
        plan = TableSegments(motion, tolerance)
    else:
        plan = Plan(motion, start, stop, kind, tolerance, rate_tolerance, scale)
    _check_names(path, name, instrument, clock if isinstance(clock, int) else -1, center)
    if frame_kernel is not None:
        instrument = _instrument_of(frame_kernel, name)
    with ExitStack() as stack:
        files: list[FilePath] = []
        if isinstance(clock, int):
            ticking = _ck_files.own(clock, plan.first, scale)
        else:
            files = [clock] if isinstance(clock, (str, os.PathLike)) else list(clock)
            ticking = stack.enter_context(_ck_files.of_mission(files, plan.first, plan.end))
        return _written(path, plan, ticking, name, instrument, center, frame_kernel, files)


def _instrument_of(frame_kernel, name):
    """The NAIF number of the frame `name`, of class 3, in a frame kernel."""
    spice = spiceypy()
    with LoadedKernels([frame_kernel]):
        number = spice.namfrm(name)
        info = spice.frinfo(number) if number else None
    if info is None or info[1] != 3:
        raise AttitudeError(
            f"{os.fspath(frame_kernel)} defines no frame {name!r} of class 3 (C-kernels); give the "
            "name of one."
        )
    return int(info[2])


def _written(path, plan, clock, name, instrument, center, frame_kernel, files):
    """Write the files of a kernel, and halve its step until it is within the tolerances."""
    stem = os.path.splitext(os.fspath(path))[0]
    kernels = [os.fspath(path)]
    numbers = {"name": name, "instrument": instrument, "clock": clock.number, "center": center}
    with ExitStack() as stack:
        temporary = stack.enter_context(made_whole(path, "the C-kernel"))
        if frame_kernel is None:
            file = stack.enter_context(written_whole(stem + ".tf", "the frame kernel"))
            file.write(_ck_files.FRAME.format(**numbers))
        kernels.append(stem + ".tf" if frame_kernel is None else os.fspath(frame_kernel))
        if clock.text is not None:
            file = stack.enter_context(written_whole(stem + ".tsc", "the clock kernel"))
            file.write(clock.text)
            kernels.append(stem + ".tsc")
        else:
            kernels += map(os.fspath, files)
        if isinstance(plan, TableSegments):
            plan.write(temporary, clock, instrument)
            error, rate_error = plan.measured(temporary, clock, instrument)
            most = plan.tolerance if clock.text else max(plan.tolerance, _OF_MISSIONS)
            if error > most:
                raise AttitudeError(
                    f"the kernel deviates by {error:.2g} rad from the table, more than {most:g}: "
                    "SPICE has Hermite polynomials of degree 3, 7, 11, ... and Lagrange ones of "
                    "odd degree to 23. Give start= and stop=, for records that follow from the "
                    f"tolerance (on the command line --tolerance {most:g}), or a larger one."
                )
        else:
            error, rate_error = _halved(temporary, plan, clock, instrument)
    return Written(tuple(kernels), plan.step, error, rate_error)


# Deviation, rad, that one double of TDB, the clock of a mission, makes at rates of up to 1 rad/s.
_OF_MISSIONS = 1.2e-7


def _halved(temporary, plan, clock, instrument):
    for _ in range(4):
        _ck_files.write(temporary, plan, clock, instrument)
        error, rate_error = _ck_files.measured(temporary, plan, clock, instrument)
        if error <= plan.tolerance and rate_error <= plan.rate_tolerance:
            return error, rate_error
        plan.step *= 0.5
        os.unlink(temporary)
    raise AttitudeError(
        f"the kernel deviates by {error:.2g} rad and {rate_error:.2g} rad/s from the motion at "
        f"steps of {2.0 * plan.step:.3g} s, more than the tolerances {plan.tolerance:g} rad and "
        f"{plan.rate_tolerance:.3g} rad/s; give larger ones."
    )


def _check_names(path, name, instrument, clock, center):
    if not path_text(path).endswith(".bc"):
        raise AttitudeError(f"{os.fspath(path)!r} does not end in .bc, as C-kernels do.")
    if not (isinstance(name, str) and name.isascii() and name.isidentifier() and len(name) <= 26):
        raise AttitudeError(
            f"name is {name!r}; give a frame name of letters A to Z, digits and _, 26 at most, "
            "the first no digit."
        )
    for what, number in (("instrument", instrument), ("clock", clock)):
        if not (isinstance(number, int) and -(2**31) < number < 0):
            raise AttitudeError(f"{what} is {number!r}; give a negative NAIF number.")
    if not (isinstance(center, int) and abs(center) < 2**31):
        raise AttitudeError(f"center is {center!r}; give the NAIF number of a body, 399 for Earth.")


def _opened(path, *, body, kernels):
    """The attitude of a frame, with the frame and clock kernels beside the C-kernel."""
    stem = os.path.splitext(os.fspath(path))[0]
    beside = [stem + ending for ending in (".tf", ".tsc") if os.path.exists(stem + ending)]
    frame = "TUMBLER" if body is None else body
    return OpenedFile(KernelAttitude([path, *beside, *kernels], frame), {})


@wraps(write)
def _write(path, motion, start, stop, *, method=None, **settings):
    if method == "linear":
        settings["kind"] = 3
    return write(path, motion, start, stop, **settings)


_own_option = partial(Option, refusal="has no meaning for a file like {output}; leave it out.")
_OPTIONS = (
    _own_option(
        "rate-tolerance",
        "largest error of rates of a C-kernel",
        {"type": float, "metavar": "RAD/S"},
    ),
    _own_option(
        "clock",
        "clock kernel of a mission (and its leap seconds) for a C-kernel",
        {"nargs": "+", "metavar": "FILE"},
    ),
    _own_option(
        "frame-kernel", "frame kernel of a mission that defines --body", {"metavar": "FILE"}
    ),
    _own_option(
        "time-scale",
        "of a C-kernel: exact at TDB, or at the epochs that SPICE makes of dates",
        {"choices": ("tdb", "spice")},
    ),
)
register(
    Format(
        name="ck",
        module=__name__,
        title="SPICE CK with .tf and .tsc",
        endings=(".bc",),
        marks=(b"DAF/CK",),
        read=_opened,
        reading=("body", "kernels"),
        write=_write,
        writing=("tolerance", "method", "body", *(option.attribute for option in _OPTIONS)),
        renamed={"body": "name"},
        holds="span",
        noun="a C-kernel",
        beside={".tf": "frame_kernel", ".tsc": "clock"},
        options=(
            *_OPTIONS,
            Option(
                "body",
                "frame of a C-kernel: the one to read, or the one to write",
                {"metavar": "FRAME"},
                of_reading=True,
            ),
            Option(
                "kernels",
                "further kernels that the C-kernel IN needs; x.tf and x.tsc beside x.bc are found",
                {"nargs": "+", "default": (), "metavar": "FILE"},
                of_reading=True,
            ),
        ),
    )
)
