"""A flight with a mission."""

from sitl.records.missions import MissionItem, MissionResult, MissionState, PlanKind
from sitl.records.modes import Mode
from sitl.records.motion import Vector3
from tests.unit.sitl.autopilot.conftest import Flight

SET_MODE, MISSION_START = 176, 300
ACCEPTED = 0


class MissionRun:
    """A flight with a mission, and what it has reached when."""

    def __init__(self, flight: Flight) -> None:
        self.flight = flight
        self.missions = flight.autopilot.missions
        self.reached: list[tuple[int, float, Vector3]] = []  # item, s since the start, place
        self.start_us = 0

    def upload(self, *plan: MissionItem, current: int = 0) -> None:
        """Upload, and in flight wait until a start is no longer refused."""
        result = self.missions.replace(PlanKind.MISSION, plan, current)
        assert result == MissionResult.ACCEPTED
        if self.flight.autopilot.armed:
            self.flight.run(0.1)
        if not self.reached:
            self.start_us = self.flight.time_us

    def start(self) -> None:
        self.flight.run(1.1)
        self.start_us = self.flight.time_us
        assert self.flight.command(MISSION_START, 0.0) == ACCEPTED
        self.step()

    def in_air(self, height_m: float = 6.0) -> None:
        """Start hovering above home."""
        self.flight.place((0.0, 0.0, -height_m))
        self.flight.run(0.1)
        self.start_us = self.flight.time_us

    def go(self) -> None:
        assert self.flight.command(SET_MODE, 1.0, 4.0, 4.0) == ACCEPTED
        self.step()

    def step(self) -> None:
        self.flight.step()
        seconds = (self.flight.time_us - self.start_us) / 1e6
        place_ned = self.flight.estimate.position_ned
        self.reached += [(item, seconds, place_ned) for item in self.missions.drain_reached()]

    def run_until_reached(self, item: int, timeout_s: float) -> float:
        end_us = self.flight.time_us + timeout_s * 1e6
        while item not in [entry[0] for entry in self.reached]:
            assert self.flight.time_us < end_us, f"item {item} not reached in {timeout_s:g} s"
            self.step()
        return (self.flight.time_us - self.start_us) / 1e6

    @property
    def items(self) -> list[int]:
        return [entry[0] for entry in self.reached]

    @property
    def mode(self) -> Mode:
        return self.flight.autopilot.status.mode

    @property
    def state(self) -> MissionState:
        return self.missions.progress.state
