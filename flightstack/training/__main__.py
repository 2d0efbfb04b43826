"""`python -m flightstack.training`."""

import sys

from flightstack.training.commands.cli import main

sys.exit(main())
