"""From brightness to the spin state: light curves of tumbling bodies inverted.

curve, curve_files     `LightCurve`: magnitudes with geometry, from arrays and files
spin_states            `spin_states`: the blind search, its options and its result
solution               `Solution` and `SpinStates`
periods                `periods`: pairs of periods by two-dimensional Fourier series
curve_problem, problem a light curve as numbers, and terms that are projected out
search                 the stages of the search; `lattices`, candidate rates; `ellipsoid_search`
refinement, robust     orientation, elements and areas together; Student's errors
facets, facet_sums     convex bodies by areas of facets, their moments and their brightness
minkowski              the closed mesh of areas and normals
states                 motion and covariance from the parameters of a search
predictions, figures   magnitudes and figures of a solution
aliases, verdicts      relations between solutions in words; what a curve decides
many_starts            Levenberg and Marquardt's iteration from many starts, compiled
normal_form_series     attitudes and derivatives from the five elements of a motion, compiled
ellipsoid_magnitudes   magnitudes of an ellipsoid with all derivatives, compiled
moments_of_elements    moments of inertia from elements in closed form, compiled
"""

from attitude.inversion.curve import LightCurve
from attitude.inversion.periods import Pair, Periods, periods
from attitude.inversion.solution import Solution, SpinStates
from attitude.inversion.spin_states import spin_states

__all__ = [
    "LightCurve",
    "Pair",
    "Periods",
    "Solution",
    "SpinStates",
    "periods",
    "spin_states",
]
