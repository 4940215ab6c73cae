"""From brightness to the spin state: light curves of tumbling bodies inverted.

curve, curve_files     `LightCurve`: magnitudes with geometry, from arrays and files
spin_states            `spin_states`: the blind search, its options and its result
solution               `Solution` and `SpinStates`
refine                 `refine`: from a start, with impulses or torques, and its `Refinement`
moving, moving_fit     motions with parameters, and their least squares with a shape
known_shape, ties      a given mesh and law; what `moments=` says
periods                `periods`: pairs of periods by two-dimensional Fourier series
curve_problem, problem a light curve as numbers, and terms that are projected out
search                 the stages of the search; `lattices`, candidate rates; `ellipsoid_search`
convex, iteration      magnitudes and priors of a convex body; the iteration of all fits
refinement, robust     orientation, elements and areas together; Student's errors
facets, facet_sums     convex bodies by areas of facets, their moments and their brightness
minkowski              the closed mesh of areas and normals
jackknife              covariances that contain the error of the model; `population`, and those of
                       densities that are not normal; `density_of_motion`
pass_search            states of a body of known shape; `known_states`, their ranking
states                 motion and covariance from the parameters of a search
predictions, figures   magnitudes and figures of a solution
aliases, verdicts      relations between solutions in words; what a curve decides
many_starts            Levenberg and Marquardt's iteration from many starts, in arrays
normal_form_series     attitudes and derivatives from the five elements of a motion, compiled
ellipsoid_magnitudes   magnitudes of an ellipsoid with all derivatives, compiled
moments_of_elements    moments of inertia from elements in closed form, compiled
"""

from attitude.inversion._curve import LightCurve
from attitude.inversion._periods import Pair, Periods, periods
from attitude.inversion._refine import Refinement, refine
from attitude.inversion._solution import Solution, SpinStates
from attitude.inversion._spin_states import spin_states

__all__ = [
    "LightCurve",
    "Pair",
    "Periods",
    "Refinement",
    "Solution",
    "SpinStates",
    "periods",
    "refine",
    "spin_states",
]
