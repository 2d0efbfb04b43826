"""Run the command line: python -m flightstack.logs."""

import gc

gc.disable()  # while importing: what imports make stays
from flightstack.logs.cli import run_and_leave  # noqa: E402

run_and_leave()
