"""Run the command line: python -m flightstack.logs."""

from flightstack.logs.cli import main
from flightstack.logs.process import leave

leave(main())
