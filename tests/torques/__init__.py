"""Tests of torques."""
