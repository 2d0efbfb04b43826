"""Run the command line: python -m flightstack.logs."""

from flightstack.logs.cli import main

raise SystemExit(main())
