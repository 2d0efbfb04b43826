"""The errors of a flight that gives no result: it died, or who flies it raised something.

LinkError
└── FlightDiedError      a process was killed, a port was lost, or time stood still for long
UsageError
└── FlightCrashedError   the same flight would raise it again
"""

from flightstack.errors import LinkError, UsageError


class FlightDiedError(LinkError):
    """It says nothing about who flew, and may be flown again."""


class FlightCrashedError(UsageError):
    """The companion raised what nobody expected, such as an error of a user's policy."""
