"""``--observed CURVE.csv``: the light curve of a mission against observations."""

from __future__ import annotations

from typing import IO, TYPE_CHECKING, Any

from attitude.cli import output
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.formats.mission import Mission

_DAY = 86400.0


def run(mission: Mission, observed: str, target: str | None, figure: str | None) -> None:
    """Write observed and computed magnitudes with a zero point a session; print each session's rms.

    Parameters
    ----------
    mission : Mission
        With a magnitude.
    observed : str
        A file that `inversion.LightCurve.read` reads; its geometry is not used.
    target : str or None
        A CSV; standard output if None.
    figure : str or None

    Raises
    ------
    AttitudeError
        For a file without epochs or magnitudes, and epochs at which nothing of the body is seen.
    """
    import numpy as np

    from attitude.inversion import curve_files

    columns, _ = curve_files.columns(observed, {})
    if "magnitude" not in columns:
        raise AttitudeError(f"{observed}: has no column of magnitudes; name one magnitude or mag.")
    assert mission.magnitude is not None
    view = mission.scene.at(columns["times"])
    computed = np.asarray(mission.magnitude.of(view, everywhere=True), dtype=float)
    given = np.asarray(columns["magnitude"], dtype=float)
    dark = np.count_nonzero(~np.isfinite(computed))
    if dark:
        raise AttitudeError(
            f"{observed}: at {dark} of {len(computed)} epochs nothing of the body is both lit and "
            "seen; leave these points out."
        )
    session = np.asarray(columns.get("session", [""] * len(given)), dtype=str)
    residual, lines = _compared(given, computed, session)
    dates = [each.utc_iso for each in _instants(view)]
    with output.opened(target) as file:
        _write(file, dates, session, given, given - residual, residual)
    print("\n".join(lines))
    if figure is not None:
        _draw(view.seconds / _DAY, given, residual, session, figure)
        print(figure)


def _instants(view: Any) -> list[Any]:
    """The epochs of reception."""
    return [view.epoch.after(float(each)) for each in view.seconds]


def _compared(
    given: FloatArray, computed: FloatArray, session: Any
) -> tuple[FloatArray, list[str]]:
    """Residuals without the mean of each session, and a line about each."""
    import numpy as np

    residual = np.empty_like(given)
    lines = []
    for name in dict.fromkeys(session.tolist()):
        here = session == name
        zero = float(np.mean(given[here] - computed[here]))
        residual[here] = given[here] - computed[here] - zero
        rms = float(np.sqrt(np.mean(residual[here] ** 2)))
        label = name or "all points"
        lines.append(
            f"{label}: {np.count_nonzero(here)} points, zero point {zero:+.3f}, rms {rms:.3f} mag"
        )
    total = float(np.sqrt(np.mean(residual**2)))
    return residual, [*lines, f"rms of all {len(given)} points: {total:.3f} mag"]


def _write(file: IO[str], dates: list[str], session: Any, *columns: FloatArray) -> None:
    file.write("utc,session,observed,computed,residual\n")
    for date, name, *numbers in zip(dates, session.tolist(), *columns, strict=True):
        file.write(f"{date},{name}," + ",".join(f"{each:.4f}" for each in numbers) + "\n")


def _draw(days: Any, given: FloatArray, residual: FloatArray, session: Any, figure: str) -> None:
    """Observed and computed magnitudes, and residuals, a colour a session."""
    from attitude import plots
    from attitude.textfiles.atomic_write import written_whole

    kind = output.kind_of(figure, output.PICTURES, "--figure")
    drawn = plots.new_figure((10.0, 7.0))
    above, below = drawn.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for name in dict.fromkeys(session.tolist()):
        here = session == name
        above.plot(days[here], given[here], ".")
        below.plot(days[here], residual[here], ".")
    above.plot(days, given - residual, "kx", ms=3, label="computed")
    above.invert_yaxis()
    above.set_ylabel("magnitude")
    above.legend()
    below.invert_yaxis()
    below.set_ylabel("residual, mag")
    below.set_xlabel("days from the epoch of the mission")
    with written_whole(figure, "--figure", binary=True) as file:
        drawn.savefig(file, format=kind, dpi=150)
