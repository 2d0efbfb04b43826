"""Entry point: python -m flightstack.live."""

from flightstack.live.cli import main

raise SystemExit(main())
