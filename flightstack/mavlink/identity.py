"""Who speaks: an autopilot of something that flies or drives, and which one."""

from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import common

from flightstack.mavlink.transport import Address

NO_VEHICLES = frozenset(
    {
        common.MAV_TYPE_ANTENNA_TRACKER,
        common.MAV_TYPE_GCS,
        common.MAV_TYPE_ONBOARD_CONTROLLER,
        common.MAV_TYPE_GIMBAL,
        common.MAV_TYPE_ADSB,
        common.MAV_TYPE_CAMERA,
    }
)
AUTOPILOTS = {common.MAV_AUTOPILOT_ARDUPILOTMEGA: "an ArduPilot"}  # as people call them


@dataclass(frozen=True, slots=True)
class VehicleIdentity:
    """Who the link speaks with."""

    system_id: int
    autopilot: int  # MAV_AUTOPILOT
    address: Address | None
    signs: bool = False  # its messages

    @property
    def is_px4(self) -> bool:
        """Whether its flight modes are known here."""
        return bool(self.autopilot == common.MAV_AUTOPILOT_PX4)

    def __str__(self) -> str:
        at = "" if self.address is None else " at {}:{}".format(*self.address)
        kind = AUTOPILOTS.get(self.autopilot, f"no PX4 (MAV_AUTOPILOT {self.autopilot})")
        return f"system {self.system_id}{at}" + ("" if self.is_px4 else f", {kind}")


def speaks_for_a_vehicle(heartbeat: Any) -> bool:
    """Whether an autopilot sends this, of something that flies or drives."""
    is_autopilot = heartbeat.autopilot != common.MAV_AUTOPILOT_INVALID
    return is_autopilot and heartbeat.type not in NO_VEHICLES
