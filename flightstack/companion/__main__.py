"""python -m flightstack.companion."""

import sys

from flightstack.companion.cli import main

sys.exit(main())
