"""Read how well a vehicle's GPS saw the sky: fix, satellites, dilution of precision."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.flight.vehicle import LoggedVehicle

UNKNOWN_COUNT = 255
UNKNOWN_HDOP = 65535
FIXES = ("no GPS", "no fix", "2D fix", "3D fix", "DGPS", "RTK float", "RTK fixed", "static", "PPP")

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GpsQuality:
    """The first GPS over time; NaN where it does not tell."""

    time_us: NDArray[np.int64]
    fix: NDArray[np.uint8]  # GPS_FIX_TYPE
    satellites: Floats
    hdop: Floats

    def __len__(self) -> int:
        return len(self.time_us)

    @property
    def usual_fix(self) -> str:
        """The fix that it had most of the time, for people."""
        most = int(np.bincount(self.fix).argmax()) if len(self) else 0
        return FIXES[most] if most < len(FIXES) else f"fix {most}"


def find_gps(log: Log, vehicle: LoggedVehicle) -> GpsQuality:
    """Return what the vehicle said of its GPS; empty where it did not."""
    table = vehicle.sent(log, "GPS_RAW_INT")
    count, hdop = table["satellites_visible"], table["eph"]
    return GpsQuality(
        time_us=table.time_us,
        fix=table["fix_type"],
        satellites=np.where(count == UNKNOWN_COUNT, np.nan, count.astype(np.float64)),
        hdop=np.where(hdop == UNKNOWN_HDOP, np.nan, hdop * 0.01),
    )
