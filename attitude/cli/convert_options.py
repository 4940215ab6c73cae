"""The options of ``attitude convert``."""

from __future__ import annotations

import argparse

from attitude.cli import orbit

HELP: str = "convert between spin files, CCSDS AEM, APM and ACM, STK, SPICE CK and tables"
EPILOG: str = """\
examples:
  attitude convert tumbler.toml tumbler.aem --stop "1 d" --tolerance 1e-7
  attitude convert toutatis.toml toutatis.aem --stop "30 d" --step "1 h"
  attitude convert "4179 Toutatis" toutatis.aem --stop "30 d" --step "1 h"
  attitude convert satellite.xml satellite.ecsv
  attitude convert satellite.aem satellite.toml --fit
  attitude convert tumbler.toml tumbler.bc --stop "2 d" --tolerance 1e-9
  attitude convert relative-to-lvlh.aem inertial.aem --frame ICRF --orbit satellite.oem
  attitude convert satellite.toml satellite.aem --for gmat --stop "1 h" --step "1 s"
  attitude convert tumbler.bc tumbler.csv --start 2026-01-01 --stop 2026-01-02 --step "1 min"

endings that OUT may have:
  .toml  spin file, exact     .aem      CCSDS AEM        .a     STK attitude
  .apm   CCSDS APM            .xml      CCSDS AEM, XML   .bc    SPICE CK with .tf and .tsc
  .acm   CCSDS ACM            .apm.xml  CCSDS APM, XML   .ecsv .fits .csv .parquet  tables
  .spin  DAMIT                .acm.xml  CCSDS ACM, XML   .cic   CIC of CNES, for VTS

The format of IN follows from its contents. A table is written record by record, or interpolated at
--start, --stop and --step; motions and C-kernels are evaluated there. --fit turns a table into a
motion.
"""
# Largest rms, rad, of the residuals of a fit that is accepted without --rms.
MOST_RMS: float = 0.01


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("input", metavar="IN", help="file to read, or a name in the catalogue")
    parser.add_argument("output", metavar="OUT", help="file to write; appears whole or not at all")
    parser.add_argument("--start", metavar="TIME", help="date (UTC), or time after the epoch of IN")
    parser.add_argument("--stop", metavar="TIME", help="last epoch, as --start")
    parser.add_argument("--step", metavar="TIME", help='time between records, such as "10 s"')
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="RAD",
        help="largest error between the records of OUT, from which the step follows (of a C-kernel "
        "1e-9 by default); of a table IN, and with --step, of the length of quaternions read",
    )
    parser.add_argument("--version", metavar="1.0|2.0", help="of CCSDS messages (default 2.0)")
    parser.add_argument("--type", metavar="NAME", help="attitude type of an AEM, section of STK")
    parser.add_argument("--frame", metavar="NAME", help="axes of OUT, such as ICRF or EME2000")
    parser.add_argument(
        "--time-system", metavar="NAME", help="of CCSDS messages: UTC, TAI, TDB, .."
    )
    _add_messages(parser)
    orbit.add_arguments(parser)
    _add_fits_and_kernels(parser)


def _add_messages(parser: argparse.ArgumentParser) -> None:
    """Options of CCSDS messages."""
    parser.add_argument(
        "--for",
        dest="tool",
        metavar="TOOL",
        help="settings of an AEM that a tool accepts: gmat, orekit, stk or brahe",
    )
    parser.add_argument(
        "--rates",
        choices=("body", "euler"),
        help="what the rates of AEM and APM 1.0 are, read or written: angular velocity, or "
        "derivatives of the Euler angles",
    )
    parser.add_argument(
        "--object", metavar="NAME", help="OBJECT_ID or OBJECT_NAME of the segments of IN to read"
    )
    parser.add_argument(
        "--segment", type=int, metavar="N", help="the one segment of IN to read, counted from 0"
    )
    parser.add_argument(
        "--lenient",
        action="store_true",
        help="read an AEM that leaves out parts of the standard; prints what was assumed",
    )


def _add_fits_and_kernels(parser: argparse.ArgumentParser) -> None:
    """Options of fits and of C-kernels."""
    parser.add_argument(
        "--split",
        action="store_true",
        help="STK: a file x-1.a, x-2.a, ... for each stretch between impulses or gaps",
    )
    parser.add_argument("--fit", action="store_true", help="fit a free rotation to the table IN")
    parser.add_argument(
        "--axes",
        choices=("principal", "free"),
        help="with --fit: whether the body axes are principal axes; by default both are tried",
    )
    parser.add_argument(
        "--rms",
        type=float,
        metavar="RAD",
        help=f"with --fit: largest rms of the residuals that is accepted (default {MOST_RMS})",
    )
    parser.add_argument(
        "--method",
        choices=("hermite", "lagrange", "linear"),
        help="interpolation that an AEM states, or of a C-kernel (hermite or linear)",
    )
    parser.add_argument(
        "--rate-tolerance", type=float, metavar="RAD/S", help="largest error of rates of a C-kernel"
    )
    parser.add_argument(
        "--clock",
        nargs="+",
        metavar="FILE",
        help="clock kernel of a mission (and its leap seconds) for a C-kernel",
    )
    parser.add_argument(
        "--frame-kernel", metavar="FILE", help="frame kernel of a mission that defines --body"
    )
    parser.add_argument(
        "--time-scale",
        choices=("tdb", "spice"),
        help="of a C-kernel: exact at TDB, or at the epochs that SPICE makes of dates",
    )
    parser.add_argument(
        "--body", metavar="FRAME", help="frame of a C-kernel: the one to read, or the one to write"
    )
    parser.add_argument(
        "--kernels",
        nargs="+",
        default=(),
        metavar="FILE",
        help="further kernels that the C-kernel IN needs; x.tf and x.tsc beside x.bc are found",
    )
