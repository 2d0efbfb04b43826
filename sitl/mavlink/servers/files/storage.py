"""What the vehicle keeps in its folder for others to fetch: metadata and flight logs."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from sitl.errors import UsageError
from sitl.mavlink.servers.files.flight_log import FlightLog
from sitl.mavlink.servers.files.metadata import Metadata
from sitl.mavlink.servers.files.vehicle_files import VehicleFiles

LOG_FOLDER = "log"


class Storage:
    """The folder and what is in it; without a folder there is nothing, and no flight is logged."""

    def __init__(
        self,
        folder: Path | None = None,
        *,
        parameters: Iterable[Mapping[str, Any]] = (),
        unix_epoch_us: int = 0,
        clock: Callable[[], int] = lambda: 0,
    ) -> None:
        """Prepare the folder; `parameters` as ground stations read them, `clock` vehicle time.

        Raises:
            UsageError: the folder cannot be written.

        """
        logs = None if folder is None else folder / LOG_FOLDER
        self.files = VehicleFiles(folder)
        self.logs = FlightLog(logs, unix_epoch_us=unix_epoch_us, clock=clock)
        self.metadata: Metadata | None = None
        if folder is not None and logs is not None:
            try:
                logs.mkdir(parents=True, exist_ok=True)
                self.metadata = Metadata(folder, parameters)
            except OSError as error:
                raise UsageError(f"--files {folder}: {error.strerror}") from None

    def close(self) -> None:
        """End the log of a flight under way."""
        self.logs.close()
