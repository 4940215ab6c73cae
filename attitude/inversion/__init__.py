"""From brightness to the spin state: light curves of tumbling bodies inverted.

normal_form_series     attitudes and derivatives from the five elements of a motion, compiled
ellipsoid_magnitudes   magnitudes of an ellipsoid with all derivatives, compiled
moments_of_elements    moments of inertia from elements in closed form, compiled
many_starts            Levenberg and Marquardt's iteration from many starts, compiled
transforms, pair_scan  Fourier series in pairs of frequencies by closed normal equations
facets, facet_sums     convex bodies by areas of facets, their moments and their brightness
problem                a light curve as numbers, and terms that are projected out
refinement             orientation, elements and areas together
"""
