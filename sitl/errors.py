"""The errors of the simulated vehicle, by what the caller does next.

SitlError
├── UsageError    the command line, environment or a file asks for what cannot be; exit code 2
└── LinkError     a socket cannot be had (port in use, no permission); exit code 3
"""

INTERRUPTED = 130  # exit code after SIGINT


class SitlError(Exception):
    """Root of all errors that the simulator raises; its text is one line fit for a user."""

    exit_code = 1


class UsageError(SitlError):
    """The user asked for something that cannot be: says what, which value, and what to do."""

    exit_code = 2


class LinkError(SitlError):
    """A socket could not be opened: says which address, why, and what to do."""

    exit_code = 3
