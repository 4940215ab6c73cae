"""Folders and files of the checkout that tests read."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Input of examples and validation, and files that only tests read.
DATA = ROOT / "data"
TEST_DATA = ROOT / "tests" / "data"
# Toutatis in December 1992.
PHOTOMETRY = DATA / "light_curve" / "toutatis-1992-photometry.csv"
# The pages that readers see first, and those of docs.
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").glob("*.md"))]
