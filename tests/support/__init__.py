"""Oracles, samplers and integrators that tests and benchmarks share."""
