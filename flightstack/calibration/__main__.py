"""python -m flightstack.calibration."""

import sys

from flightstack.calibration.cli import main

sys.exit(main())
