"""Tests of light_curve."""
