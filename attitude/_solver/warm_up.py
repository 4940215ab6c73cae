"""Compilation ahead of use, by two processes in parallel.

Numba compiles one function at a time in a process.  The functions that a propagation may need are
divided into two groups that take about as long.  Each function is called for no bodies, which
compiles it or loads it from the disk cache, where both processes find it afterwards.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from attitude._compilation.choice import compiling
from attitude._compilation.deferral import uncollected
from attitude._solver.records import CONSTANTS


def compile_ahead() -> None:
    """Compile what is not in the disk cache, in a second process; not on a single core."""
    if not sys.executable or _cores() < 2:
        return
    package = Path(__file__).parent.parent
    paths = [str(package.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    other = subprocess.Popen(
        [sys.executable, "-P", "-c", f"from {__name__} import compile_loops as c; c()"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        compile_stages()
    except BaseException:  # such as Ctrl-C: the other process must not run on
        other.kill()
        raise
    finally:
        other.wait()


def compile_stages() -> None:
    """Compile the stages from a state to rates and phases."""
    with uncollected(), compiling():
        from attitude._solver.constants import refine_all, solve_all, uniform_all
        from attitude._solver.evaluation import prepared

        constants, wxyz, principal = _no_bodies()
        prepared(_no_pairs(), wxyz, _no_pairs(), principal)
        refine_all(constants)
        solve_all(constants)
        uniform_all(wxyz, wxyz, principal, constants)


def compile_loops() -> None:
    """Compile the stages of the series and of the given axes, and the loops over epochs."""
    with uncollected(), compiling():
        from attitude._solver import constants as solver_constants
        from attitude._solver.evaluation import OF_FORM
        from attitude._solver.kernel import attach_all

        constants, wxyz, principal = _no_bodies()
        for stage in (
            solver_constants.trigonometric_all,
            solver_constants.hyperbolic_all,
            solver_constants.trigonometric_rates_all,
            solver_constants.hyperbolic_rates_all,
        ):
            stage(constants)
        attach_all(wxyz, wxyz, principal, constants)
        # As in `attitude._solver.evaluation`: one type of array.
        t = np.zeros((1, 0))
        t.flags.writeable = constants.flags.writeable = False
        for loop in OF_FORM.values():
            loop(constants, t, None, np.zeros((0, 4, 0)), np.zeros((0, 3, 0)), 0, 0, 0)


def _no_pairs():
    return np.zeros((0, 3, 2))


def _no_bodies():
    return np.zeros(0, CONSTANTS), np.zeros((0, 4)), np.zeros((1, 4))


def _cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
