"""MAVLink log inspection: a tlog as columns, and what it says about the flight.

>>> from flightstack.logs import read
>>> log = read("flight.tlog")
>>> log["ATTITUDE"]["roll"]  # numpy array, radians
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flightstack.logs.columns.log import Log
    from flightstack.logs.columns.reading import read, read_bytes, read_windows
    from flightstack.logs.columns.table import Table
    from flightstack.logs.errors import LogFileError

__all__ = ["Log", "LogFileError", "Table", "read", "read_bytes", "read_windows"]


def __getattr__(name: str) -> Any:
    """Import the reader when it is first used, so that `--help` needs no numpy."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from flightstack.logs import errors  # noqa: PLC0415
    from flightstack.logs.columns import log, reading, table  # noqa: PLC0415

    homes = (errors, log, reading, table)
    return next(getattr(home, name) for home in homes if hasattr(home, name))
