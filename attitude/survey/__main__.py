"""``python -m attitude.survey run ...``: the command ``sorcha run`` with light-curve classes."""

from __future__ import annotations

import sys

from attitude import survey
from attitude._support import validation


def main() -> None:
    """Run ``sorcha run`` with the arguments of the command line."""
    if not hasattr(survey, "LightCurve"):
        sys.exit(f"sorcha is not installed: {validation.installing('sorcha')}.")
    from sorcha_cmdline.run import main as run

    if sys.argv[1:2] == ["run"]:
        del sys.argv[1]
    run()


if __name__ == "__main__":
    main()
