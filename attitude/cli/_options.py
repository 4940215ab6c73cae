"""Arguments that several commands have: the motion, equally spaced epochs, ``--orbit``.

Epochs are computed block by block.  Steps, and times after the epoch, are seconds of UTC (leap
seconds count), so that 00:00 is followed by 01:00; they are seconds of TDB if the start is a date
in TDB.  The two differ by microseconds.
"""

from __future__ import annotations

import argparse
import math
import os
import re
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import catalog
from attitude._support import pairs, quantity_text
from attitude.epochs import _inputs, _instants, _time_scales
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import FloatArray
    from attitude.catalog import Entry
    from attitude.formats._format import Format, Option
    from attitude.formats.spin_file import SpinFile
    from attitude.motions._free_rotation import FreeRotation
    from attitude.paths._path import Path, Place
    from attitude.torques._torqued import TorquedRotation

    Pair = tuple[FloatArray, FloatArray]  # high and low parts, s


# A longer table is a mistake: a terabyte of text.
_MOST_ROWS = 10**10
_SHORTEST = Fraction(1, 10**9)
# Seconds since J2000 of the beginning of the year 0001, and of the end of 9999.
_FIRST = -63082281600.0
_LAST = 252455529600.0
# s, of the longest time after the epoch beyond the calendar: twice the age of the universe.
_FARTHEST = 10**18
# From 1972 on, in seconds since J2000, UTC has the seconds of TAI.
_EVEN_UTC = -883655957.9
# The stop is included if a whole number of steps misses it by no more, in steps.
_ROUNDING = Fraction(1, 10**9)


@dataclass(frozen=True)
class Grid:
    """Epochs start + k step, 0 <= k < count, of s of UTC or TDB; `block`: s since the epoch."""

    epoch: _instants.Instant
    start: _instants.Instant
    step: Fraction
    count: int
    uniform_in: str

    def block(self, first: int, count: int) -> Pair:
        """TDB seconds since the epoch, hi, lo (N,), of at most `count` epochs from `first` on."""
        number = np.arange(first, min(first + count, self.count), dtype=np.float64)
        elapsed = _times(number, self.step)
        offset = pairs.add(
            (self.start.seconds, self.start.low), -self.epoch.seconds, -self.epoch.low
        )
        seconds = pairs.add(offset, *elapsed)
        if self.uniform_in == "tdb":
            return seconds
        tt0 = _tt(self.start)
        then = _time_scales.difference_at(*pairs.add(tt0, *elapsed))
        change = then - _time_scales.difference_at(np.float64(tt0[0]), np.float64(tt0[1]))
        # The difference from an array and from one number may differ by 5e-15 s.
        return pairs.add(seconds, np.where(number == 0.0, 0.0, change))

    @property
    def digits(self) -> int:
        """Decimals of a second that the dates in UTC need: 0, 3, 6 or 9.

        Before 1972 seconds of UTC were longer than those of the steps.
        """
        last = self.start.seconds + float(self.step) * (self.count - 1)
        is_even = self.uniform_in == "utc" and min(self.start.seconds, last) >= _EVEN_UTC
        if not is_even and self.count > 1:
            return 9
        step = self.step if self.count > 1 else Fraction(0)
        decimals = re.search(r"\.(\d+)$", self.start.utc_iso)
        fraction = Fraction("0." + decimals.group(1)) if decimals else Fraction(0)
        for digits in (0, 3, 6):
            if (fraction * 10**digits).denominator == (step * 10**digits).denominator == 1:
                return digits
        return 9


def grid(
    epoch: _instants.Instant,
    start: str,
    stop: str,
    step: str,
    *,
    is_tdb: bool = False,
    is_far: bool = False,
) -> Grid:
    """The Grid of the texts of --start, --stop and --step, in seconds of UTC, or else of TDB.

    is_far: start and stop are times after the epoch, in TDB, as `is_beyond_dates` says.
    """
    pace = duration(step, "--step")
    if pace == 0:
        raise AttitudeError('--step is zero; give the time between two rows, like "10 s" or "1 h".')
    if abs(pace) < _SHORTEST:
        raise AttitudeError(
            f"--step is {step}; give at least 1e-9 s, the shortest step that dates resolve."
        )
    first, last = _moment(start, "--start"), _moment(stop, "--stop")
    is_tdb = is_tdb or is_far or re.search(r"\bTDB\s*$", start, re.IGNORECASE) is not None
    uniform_in = "tdb" if is_tdb else "utc"
    begin = _instant(first, epoch, uniform_in, "--start", start)
    end = begin if is_far else _instant(last, epoch, uniform_in, "--stop", stop)
    if isinstance(first, Fraction) and isinstance(last, Fraction):
        span = last - first
    elif is_tdb:
        span = _exact((end.seconds, end.low)) - _exact((begin.seconds, begin.low))
    else:
        span = _exact(_tt(end)) - _exact(_tt(begin))
    if span * pace < 0 and abs(span) > _ROUNDING:
        where = "before" if span < 0 else "after"
        since, counted = "", stop if isinstance(last, Fraction) else start
        if type(first) is not type(last):
            since = f" ({counted} counts from the epoch, {epoch.utc_iso} UTC)"
        raise AttitudeError(
            f"--stop {stop} lies {where} --start {start}{since}, but --step is {step}; exchange "
            "the two, or change the sign of the step."
        )
    count = math.floor(span / pace + _ROUNDING) + 1
    if count > _MOST_ROWS:
        raise AttitudeError(
            f"--step {step} makes {count} rows, more than {_MOST_ROWS}; take a longer step."
        )
    return Grid(epoch, begin, pace, max(count, 1), uniform_in)


def one(epoch: _instants.Instant, text: str, name: str) -> _instants.Instant:
    """The Instant of one text, as --start of `grid`; the name begins error messages."""
    return _instant(_moment(text, name), epoch, "utc", name, text)


def is_beyond_dates(epoch: _instants.Instant, text: str, name: str) -> bool:
    """Whether a text is a time after the epoch that leads out of the years 0001 to 9999."""
    moment = _moment(text, name)
    if not isinstance(moment, Fraction) or abs(moment) > _FARTHEST:
        return False
    return not has_date(epoch.seconds + float(moment))


def has_date(seconds: Any) -> Any:
    """Whether seconds since J2000 lie in the years 0001 to 9999."""
    return (seconds >= _FIRST) & (seconds < _LAST)


def duration(text: str, name: str) -> Fraction:
    """Seconds as an exact fraction, of text such as "10", "0.1 s" or "3 d"."""
    numbers, unit = quantity_text.numbers_and_unit(text, name)
    if len(numbers) != 1:
        raise AttitudeError(f'{name} is {text!r}; give one time, like "10 s" or "3 d".')
    size = float(numbers[0])
    if math.isinf(size):
        raise _out_of_calendar(name, text)
    length = Fraction(numbers[0]) if size else Fraction(0)  # of 1e-99999999 there is no fraction
    factor = quantity_text.common_factor(unit, "s")
    if factor is not None:
        return length * Fraction(repr(factor))
    if unit:
        from astropy import units

        try:
            # The shortest decimal of the factor: 0.001 s for a ms, not the double nearest to it.
            length *= Fraction(repr(float(quantity_text.unit_of(unit, name).to("s"))))
        except units.UnitConversionError:
            raise AttitudeError(
                f'{name} is {text!r}; give a time, like "10 s", "1 h" or "3 d".'
            ) from None
    return length


def periods(text: str, name: str) -> list[str]:
    """The times of a text, each with its unit: "5.7, 5.8 h" are "5.7 h" and "5.8 h"."""
    parts = [quantity_text.numbers_and_unit(piece, name) for piece in text.split(",")]
    common = parts[-1][1]
    if not common and any(unit for _, unit in parts):
        raise AttitudeError(
            f'{name} is {text!r}, whose last number has no unit; write it like "5.7, 5.8 h".'
        )
    times = [f"{number} {unit or common}".strip() for numbers, unit in parts for number in numbers]
    if len(times) > 2:
        raise AttitudeError(f'{name} is {text!r}; give one time or two, like "5.7, 5.8 h".')
    return times


def _moment(text: str, name: str) -> _instants.Instant | Fraction:
    """A date as Instant, a time after the epoch as Fraction."""
    if re.match(r"\s*(\d{4,}-\d|M?JD *\d)", text, re.IGNORECASE):
        return _inputs.instant(text, name)
    try:
        return duration(text, name)
    except AttitudeError as err:
        if re.match(r"\s*[-+.]?\d", text):
            raise
        raise AttitudeError(
            f'{name} is {text!r}; give a date in UTC like "2026-01-01T00:00:00", or a time after '
            'the epoch like 3600 or "3 d".'
        ) from err


def _instant(moment, epoch, scale, name, text):
    if isinstance(moment, _instants.Instant):
        instant = moment
    else:
        # Checked before it becomes a float: 10**400 has none.
        if abs(moment) > Fraction(_LAST - _FIRST):
            raise _out_of_calendar(name, text)
        hi = float(moment)
        lo = float(moment - Fraction(hi))
        if scale == "tdb":
            instant = epoch.after(hi, lo)
        elif moment == 0:
            instant = epoch
        else:
            tt = pairs.add(_tt(epoch), hi, lo)
            tdb = _time_scales.tdb_from("tt", np.float64(tt[0]), np.float64(tt[1]))
            instant = _instants.Instant(float(tdb[0]), float(tdb[1]))
    if not has_date(instant.seconds):
        raise _out_of_calendar(name, text)
    return instant


def _out_of_calendar(name: str, text: str) -> AttitudeError:
    return AttitudeError(
        f"{name} is {text}, which leads out of the years 0001 to 9999; give an epoch within them."
    )


def _tt(instant: _instants.Instant) -> tuple[float, float]:
    """TT seconds since J2000."""
    hi, lo = _time_scales.tt_from_tdb(np.float64(instant.seconds), np.float64(instant.low))
    return float(hi), float(lo)


def _exact(pair: tuple[float, float]) -> Fraction:
    return Fraction(float(pair[0])) + Fraction(float(pair[1]))


def _times(number: FloatArray, step: Fraction) -> Pair:
    """The products of whole numbers below 2**34 and a fraction, as a pair without loss."""
    # 19 bits of the step at a time, so that each product with a number of 34 bits is exact.
    hi, lo, remainder = 0.0 * number, 0.0 * number, step
    while remainder:
        mantissa, exponent = math.frexp(float(remainder))
        leading = math.ldexp(math.trunc(math.ldexp(mantissa, 19)), exponent - 19)
        remainder -= Fraction(leading)
        hi, lo = pairs.add((hi, lo), number * leading)
        if abs(remainder) * 2**140 < abs(step):
            break
    return hi, lo


# ---- ``--orbit PLACE``: the path of a body about its center; ``--site PLACE``: the observer


_ORBITS = (
    "OEM, TLE, OMM, SPK, MPCORB line (or a file of them), elements (text or TOML), mission file or "
    "planet: the path of the body about the center that it names"
)


def add_orbit_arguments(parser: argparse.ArgumentParser, purpose: str = _ORBITS) -> None:
    """Add the options --orbit and --orbit-of."""
    parser.add_argument(
        "--orbit",
        metavar="PLACE",
        help=purpose,
    )
    parser.add_argument(
        "--orbit-of",
        metavar="NAME",
        help="the target of an SPK (name or NAIF number), or one body of several in a TLE, OMM or "
        "MPCORB.DAT (name or number)",
    )


def path_of(arguments: argparse.Namespace) -> Path | None:
    """The path given by the options; None without them."""
    file, name = arguments.orbit, arguments.orbit_of
    if file is None:
        if name is not None:
            raise AttitudeError("--orbit-of names a body of an orbit; give the file with --orbit.")
        return None
    from attitude.paths import _composed, _places
    from attitude.paths._path import Path

    path = _places.place(file, "--orbit", of=name)
    if not isinstance(path, Path):
        raise AttitudeError(f"--orbit {file!r} is a direction, infinitely far away; give a path.")
    if isinstance(path, _composed.NamedBody) and path.name != "sun":
        return _composed.body(path.name, center="sun")
    if path.center == "ssb":
        raise AttitudeError(
            f"--orbit {file!r} gives {path.name} relative to the barycenter of the solar system; "
            "give a file whose center is the body at the focus of the orbit."
        )
    return path


def of_formats(*, of_reading: bool = False) -> list[Option]:
    """The options that the registered formats add to commands: all, or those of reading."""
    from attitude.formats._format import formats

    all_options = [option for entry in formats().values() for option in entry.options]
    return [option for option in all_options if option.of_reading or not of_reading]


def of_reading(
    arguments: argparse.Namespace, what: str, read: Format | None, writing: Sequence[str] = ()
) -> dict[str, Any]:
    """Keywords of `detect.opened` from the options of reading.

    AttitudeError for one that neither the format read has, nor the options `writing` of OUT.
    """
    names = [option.attribute for option in of_formats(of_reading=True)]
    keywords = {name: name.removesuffix("_in") for name in names}
    known = () if read is None else read.reading
    others = [name for name in names if keywords[name] not in known and name not in writing]
    refuse(arguments, others, what)
    return {keywords[name]: getattr(arguments, name) for name in names}


def site_of(arguments: argparse.Namespace) -> Place | None:
    """The observer of --site; None without it, AttitudeError without --orbit."""
    if arguments.site is None:
        return None
    if arguments.orbit is None:
        raise AttitudeError("--site needs the orbit of the body; give --orbit.")
    from attitude.paths import _places

    return _places.place(arguments.site, "--site", is_observer=True)


def add_site_argument(parser: argparse.ArgumentParser) -> None:
    """Add --site."""
    parser.add_argument(
        "--site",
        metavar="PLACE",
        help='the observer, with --orbit: the code ("568") or the name of an observatory, '
        '"-70.7, -30.2 deg, 2700 m", or a body (default: earth)',
    )


# ---- The motion that a command is run for: that of a file, or a completed entry of the catalogue

# Keyword of catalog.load, with unit and help; and of words, with help.
_NUMBERS = {
    "moments": (None, "three moments about the body axes, or their ratios"),
    "P_psi": ("s", 'period, such as "6.58 h"'),
    "P_phi": ("s", 'period, such as "7.35 h"'),
    "pole": ("rad", 'longitude and latitude, such as "250, -75 deg"'),
    "phi0": ("rad", 'angle at the epoch, such as "152 deg"'),
    "psi0": ("rad", 'angle at the epoch, such as "-3 deg"'),
    "wxyz": (None, "attitude from body axes to the frame"),
    "angular_velocity": ("rad/s", 'such as "1, 0, 3 deg/s", body axes'),
}
_WORDS = {
    "mode": "LAM or SAM",
    "convention": "L or S: phi of the long or the short axis",
    "theta_branch": "acute or obtuse, where psi librates; obtuse for theta0 above 90 deg",
    "epoch": "date in UTC; alone: one to which the state is propagated",
    "frame": "frame of the pole or of wxyz",
}


_FILES = "a body and its state in a file: spin file (.toml), APM, ACM, or DAMIT spin file (.spin)"


def add_target_arguments(parser: argparse.ArgumentParser, files: str = _FILES) -> None:
    """Add NAME|FILE, and the options that complete an entry of the catalogue."""
    parser.add_argument(
        "target", metavar="NAME|FILE", help=f"name in the catalogue (or a part of it), or {files}"
    )
    group = parser.add_argument_group("values that an entry of the catalogue lacks")
    for name, (_, text) in _NUMBERS.items():
        group.add_argument(_option(name), metavar="NUMBERS", nargs="+", help=text)
    for name, text in _WORDS.items():
        group.add_argument(_option(name), metavar="WORD", help=text)


def _option(name: str) -> str:
    """The option of a keyword, of whose values argparse makes an attribute of that name."""
    return f"--{name.replace('_', '-')}"


def is_file(text: str) -> bool:
    """Whether a target is a file: one that exists, or a name of the form of a path."""
    written_so = re.search(r"\.[A-Za-z]\w*$|[/\\]", text) is not None
    return os.path.isfile(text) or (written_so and not catalog.has(text))


def motion_of(arguments: argparse.Namespace) -> FreeRotation | TorquedRotation:
    """The motion of parsed arguments; that of a mission file with sections [[torque]] too."""
    if is_file(arguments.target) and content_of_mission(arguments.target):
        from attitude.formats import mission

        refuse_completing(arguments)
        return mission.read_motion(arguments.target)
    return opened(arguments)[0].motion


def opened(arguments: argparse.Namespace) -> tuple[SpinFile, str]:
    """The state of parsed arguments, and its name with what is not that of its sources."""
    from attitude.formats.spin_file import SpinFile

    if is_file(arguments.target):
        state = _from_file(arguments)
        state = replace(state, name=state.name or arguments.target)
        return state, str(state.name)
    entry, label = catalog.entry(arguments.target), ""
    values, options = _given(arguments), completing(arguments)
    if entry.is_propagated({name: value for name, value in values.items() if value is not None}):
        options.remove("--epoch")
        label = ", propagated to --epoch"
    if options:
        label = f", with {', '.join(options)} as given here{label}"
    motion, sources = entry.motion(**values), "; ".join(entry.sources)
    state = SpinFile(motion.body, motion.spin, entry.name, sources, entry.note)
    return state, entry.name + label


def incomplete(arguments: argparse.Namespace) -> Entry | None:
    """The entry of the catalogue, if values are missing in it and no option gives one."""
    if is_file(arguments.target) or completing(arguments):
        return None
    entry = catalog.entry(arguments.target)
    return entry if entry.missing else None


def content_of_mission(path: str) -> dict[str, Any]:
    """The content of a file that is a mission file; empty if it is none."""
    from attitude._textfiles import toml
    from attitude.formats.spin_file import OF_MISSIONS

    if not path.lower().endswith(".toml"):
        return {}
    content = toml.parsed(toml.read(path, "spin file"), path)
    is_mission = bool(OF_MISSIONS & content.keys()) or isinstance(content.get("spin"), str)
    return content if is_mission else {}


def _from_file(arguments):
    path = arguments.target
    refuse_completing(arguments)
    content = content_of_mission(path)
    if not content:
        from attitude.formats import detect

        return detect.read_state(path)
    from attitude.formats import mission
    from attitude.formats.spin_file import SpinFile
    from attitude.motions._free_rotation import FreeRotation

    motion = mission.read_motion(path)
    if not isinstance(motion, FreeRotation):
        raise AttitudeError(
            f"{path}: the body moves under torques; give it to attitude propagate or evolve, or a "
            "file without [[torque]] for its free rotation."
        )
    labels = [content.get(key) for key in ("name", "source", "note")]
    return SpinFile(motion.body, motion.spin, *labels)


def _given(arguments: argparse.Namespace) -> dict[str, Any]:
    """The keywords of the options."""
    from attitude._support import validation

    values: dict[str, Any] = {}
    for name, (unit, _) in _NUMBERS.items():
        words = getattr(arguments, name)
        if words is not None:
            numbers = validation.real(" ".join(words), _option(name), unit=unit)
            values[name] = numbers[()] if numbers.size > 1 else float(numbers.reshape(()))
    return values | {name: getattr(arguments, name) for name in _WORDS}


def completing(arguments: argparse.Namespace) -> list[str]:
    """The options given that complete an entry of the catalogue."""
    names = (*_NUMBERS, *_WORDS)
    return [_option(name) for name in names if getattr(arguments, name) is not None]


def refuse_completing(arguments: argparse.Namespace) -> None:
    """Raise the AttitudeError for options that complete an entry, beside a file."""
    useless = completing(arguments)
    if useless:
        raise AttitudeError(
            f"{', '.join(useless)} can complete an entry of the catalogue; write such values into "
            "the file."
        )


def refuse(arguments: argparse.Namespace, names: Sequence[str], what: str) -> None:
    """Raise the AttitudeError for the first given option of these, which `what` does not have."""
    for name in names:
        value = getattr(arguments, name)
        if value not in (None, ()) and value is not False:
            raise AttitudeError(f"{_option(name)} has no meaning for {what}; leave it out.")
