"""``python -m attitude`` runs the command ``attitude``."""

import sys

from attitude.cli import main

if __name__ == "__main__":
    sys.exit(main())
