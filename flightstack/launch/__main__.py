"""python -m flightstack.launch."""

import sys

from flightstack.launch.cli import main

sys.exit(main())
