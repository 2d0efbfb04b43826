"""What can go wrong while training, beside the user's and the model's faults."""

from flightstack.errors import FlightstackError


class TrainingError(FlightstackError):
    """A training diverged, or ended with a network that must not fly; exit code 1."""
