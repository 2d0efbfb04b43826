"""What can be wrong with a request for a log; each text is one line that says what to do."""

from flightstack.errors import UsageError


class LogFileError(UsageError):
    """The path holds no MAVLink log that can be read."""


class UnknownNameError(UsageError, KeyError):
    """A message, field, check or format of that name does not exist."""

    def __str__(self) -> str:
        """Return the text itself, not its repr as a KeyError would."""
        return str(self.args[0])


class ExpressionError(UsageError):
    """A condition or a field expression does not parse, or cannot be computed."""
