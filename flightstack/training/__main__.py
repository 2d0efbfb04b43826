"""`python -m flightstack.training`."""

import sys

from flightstack.training.cli import main

sys.exit(main())
