"""The error of a flight that died: it says nothing about who flew, and is flown again."""

from flightstack.errors import FlightstackError


class FlightDiedError(FlightstackError):
    """A process was killed, a port was lost, or time stood still for long."""
