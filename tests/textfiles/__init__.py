"""Tests of textfiles."""
