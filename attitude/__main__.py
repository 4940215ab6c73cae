"""``python -m attitude`` runs the command ``attitude``."""

from __future__ import annotations

import sys

from attitude.cli import main

if __name__ == "__main__":
    sys.exit(main())
