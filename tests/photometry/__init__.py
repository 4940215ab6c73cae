"""Tests of photometry."""
