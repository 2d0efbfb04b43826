"""The parameters of every part of the autopilot, resolved at once after a change."""

from typing import NamedTuple, Self

from sitl.autopilot.command.commander import CommanderParameters
from sitl.autopilot.command.health_watch import HealthParameters
from sitl.autopilot.command.missions import PlanParameters
from sitl.autopilot.command.mode_entry import EntryParameters
from sitl.autopilot.command.stick_override import OverrideParameters
from sitl.autopilot.control.cascade import CascadeParameters
from sitl.autopilot.control.limits import LimitParameters
from sitl.autopilot.flight_modes.geofence import FenceParameters
from sitl.autopilot.flight_modes.land_detector import LandDetectorParameters
from sitl.autopilot.flight_modes.manual import ManualParameters
from sitl.autopilot.flight_modes.mission import MissionParameters
from sitl.autopilot.flight_modes.navigator import NavigatorParameters
from sitl.autopilot.flight_modes.offboard import OffboardParameters
from sitl.autopilot.flight_modes.takeoff import TakeoffParameters
from sitl.autopilot.parameters import ParameterValues


class AutopilotParameters(NamedTuple):
    """One record per part, each resolved by its own rules."""

    health: HealthParameters
    commander: CommanderParameters
    plans: PlanParameters
    entry: EntryParameters
    stick_override: OverrideParameters
    fence: FenceParameters
    mission: MissionParameters
    navigator: NavigatorParameters
    offboard: OffboardParameters
    manual: ManualParameters
    takeoff: TakeoffParameters
    land_detector: LandDetectorParameters
    limits: LimitParameters
    cascade: CascadeParameters

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        parts = cls.__annotations__.items()
        return cls(**{name: part.resolve(values) for name, part in parts})
