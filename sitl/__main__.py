"""Run `python -m sitl`."""

import sys

from sitl.process.cli import main

sys.exit(main())
