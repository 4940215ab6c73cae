"""Folders of the checkout that tests read."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Input of examples and validation, and files that only tests read.
DATA = ROOT / "data"
TEST_DATA = ROOT / "tests" / "data"
