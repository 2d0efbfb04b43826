"""Say in one line what cannot be written: a full disk, or something that stands in the way."""

from collections.abc import Iterator
from contextlib import contextmanager

from flightstack.errors import UsageError


@contextmanager
def write_errors_as_usage() -> Iterator[None]:
    """Raise UsageError, with the path, for every OSError inside."""
    try:
        yield
    except OSError as error:
        where = error.filename2 or error.filename or "the folder"
        raise UsageError(f"{where} cannot be written: {error.strerror or error}") from error
