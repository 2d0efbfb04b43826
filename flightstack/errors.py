"""The errors of the companion side, by what the caller does next.

FlightstackError
├── UsageError    command line, configuration or input data is wrong; exit code 2
├── LinkError     no vehicle, no socket or no camera can be reached; exit code 3
└── ModelError    a model is unknown, damaged or does not fit its configuration; exit code 4

Each text is one line fit for a user: what, which value, what to do. A hazard in flight (a lost
frame, a late heartbeat) is never raised: it is a decision that the loop returns.
"""


class FlightstackError(Exception):
    """Root of all errors that flightstack raises."""

    exit_code = 1


class UsageError(FlightstackError):
    """The user asked for something that cannot be."""

    exit_code = 2


class LinkError(FlightstackError):
    """A vehicle, socket or camera could not be reached."""

    exit_code = 3


class ModelError(FlightstackError):
    """A model is unknown, damaged, or does not fit its configuration."""

    exit_code = 4
