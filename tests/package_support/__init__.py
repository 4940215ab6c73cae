"""Tests of `attitude/_support/`; what tests share stands in tests/support/."""
