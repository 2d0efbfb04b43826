"""Fly one course: flightstack.launch from a checkout, wherever the command is given."""

import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from flightstack.launch.cli import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(main())
