"""From brightness to the spin state: light curves of tumbling bodies inverted.

_spin_states   `spin_states`: the blind search, its options and its result
_refine        `refine`: from a start, with impulses or torques, and its `Refinement`
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
_apparitions   rotations about one axis over many years; _joined, tumbling over several apparitions
_known         the search for states of a body of known shape
_pole_map      poles of a rotation about one axis
_states        motion and covariance from the parameters of a search, posterior samples
_errors        covariances that contain the error of the model
_verdicts      relations between solutions in words; what a curve decides
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.inversion._refine import Refinement, refine
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
