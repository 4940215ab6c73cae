"""Tests of scattering."""
