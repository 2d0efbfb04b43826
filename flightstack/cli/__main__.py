"""python -m flightstack.cli."""

import sys

from flightstack.cli.main import main

sys.exit(main())
