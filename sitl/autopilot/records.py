"""The records of the autopilot's face, which stand in `sitl.vehicle_records`."""

from sitl.vehicle_records import (
    IDENTITY,
    NAN_VECTOR,
    Command,
    CommandResult,
    OffboardSetpoint,
    SetpointEcho,
    VehicleStatus,
)

__all__ = [
    "IDENTITY",
    "NAN_VECTOR",
    "Command",
    "CommandResult",
    "OffboardSetpoint",
    "SetpointEcho",
    "VehicleStatus",
]
