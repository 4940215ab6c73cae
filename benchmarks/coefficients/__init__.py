"""Coefficients of the package recomputed with mpmath; see benchmarks/make_coefficients.py.

sources       where numbers stand in the package, and which have more digits than a typed constant
table         `CoefficientTable`: stored numbers, how to recompute them, largest errors
minimax       `PolynomialFit`: least-maximum polynomials (exchange algorithm) and interpolating ones
rules         nodes and weights of quadrature, weights of differences
free_motion   the free motion over one piece in high precision, for truncation errors
composition   order conditions of splitting schemes
polynomials, numbers, motion, schemes   the tables
"""
