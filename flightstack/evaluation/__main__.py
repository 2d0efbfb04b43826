"""python -m flightstack.evaluation."""

import sys

from flightstack.evaluation.cli import main

sys.exit(main())
