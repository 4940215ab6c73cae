"""From brightness to the spin state: light curves of tumbling bodies inverted.

How to use it::

    from attitude import inversion, paths

    orbit = paths.mpc_orbit(line)  # or an OEM file, an SPK, elements ...
    curve = inversion.LightCurve.read("curve.csv", path=orbit, site="568")
    found = inversion.spin_states(curve, max_frequency="3 /d")
    print(found)  # a verdict, and the states that the curve allows, the best first
    best = found[0]
    best.motion, best.shape  # a FreeRotation with the errors of its state; a convex mesh
    best.published("L")  # periods, pole and angles as papers print them
    best.predict(["2026-03-01T20:00", "2026-03-01T21:00"])  # magnitudes of another night
    best.write("solution.toml")
    inversion.refine(curve, best)  # from a start; arcs= and torques= change the motion

`docs/inversion.md` says what a light curve can and cannot tell, and how the search works.

_spin_states   `spin_states`: the blind search, its options and its result
_from_start    `refine`: from a start, with impulses or torques, and its `Refinement`
_solution      `Solution` and `SpinStates`, predicted magnitudes; _figures, their figures
_problem       a light curve as numbers, and terms that are projected out
_search        the stages of the search; _lattices, candidate rates
_ellipsoid     magnitudes of an ellipsoid with all derivatives; ellipsoids from many starts
_shapes        convex bodies by areas of facets, given meshes, and their magnitudes
_refinement    orientation, elements and areas together
_evidence      Student's errors, and what solutions are ranked by
_settings      the thresholds of a search, and the work that it counts
_motions       attitudes and moments of inertia from the five elements, compiled
_moving        motions with parameters, and their least squares with a shape
_neighbours    outliers, noise and correlation, from neighbours in time, and nights
_satellites    rotation about one axis beside an additive series: bodies with a moon
_apparitions   rotations about one axis over many years; _joined, tumbling over several apparitions
_known         the search for states of a body of known shape
_pole_map      poles of a rotation about one axis
_states        motion and covariance from the parameters of a search, posterior samples
_errors        covariances that contain the error of the model
_verdicts      relations between solutions in words; what a curve decides
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.inversion._from_start import Refinement, refine
from attitude.inversion._settings import Settings
from attitude.inversion._solution import Prediction, Solution, SpinStates
from attitude.inversion._spin_states import spin_states
from attitude.photometry import LightCurve

__all__ = [
    "LightCurve",
    "Prediction",
    "Refinement",
    "Settings",
    "Solution",
    "SpinStates",
    "refine",
    "spin_states",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
