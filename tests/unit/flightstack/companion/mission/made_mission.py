"""A mission and the vehicle that it sees, as a test wants them."""

from dataclasses import replace
from typing import Any

from flightstack.companion.mission.machine import advance
from flightstack.companion.mission.records import (
    Hold,
    MissionPhase,
    MissionRequest,
    MissionStatus,
    Situation,
)
from flightstack.mavlink.telemetry import Course, LandedState, Telemetry
from flightstack.px4_modes import Px4Mode

S = 1_000_000
NOW = 100 * S
UNSEEN_US = -1  # no heartbeat
READY = Telemetry(
    custom_mode=Px4Mode.LOITER,
    armable=True,
    landed=LandedState.ON_GROUND,
    home_altitude_amsl_m=489.4,
    velocity_ned=(0.0, 0.0, 0.0),
)
AIRBORNE = replace(READY, armed=True, armable=False, landed=LandedState.IN_AIR)
OFFBOARD = replace(AIRBORNE, custom_mode=Px4Mode.OFFBOARD)
IN_FLIGHT = [MissionPhase.TAKING_OFF, MissionPhase.ENTERING_OFFBOARD, MissionPhase.FLYING]
COURSE = Course(gates_passed=2, gates_total=8)


class Mission:
    """A mission in some phase since NOW, and what it has asked for."""

    def __init__(self, phase: MissionPhase = MissionPhase.WAITING, **status: Any) -> None:
        entered = {"entered_us": NOW, "offboard_us": NOW if phase is MissionPhase.FLYING else None}
        self.status = MissionStatus(phase=phase, **(entered | status))
        self.requests: list[MissionRequest] = []

    def see(
        self,
        vehicle: Telemetry,
        after_s: float = 0.0,
        *,
        stop: bool = False,
        image_age_s: float = 0,
        hold: Hold | None = None,
        silent: bool = False,
        gone: bool = False,
        other: bool = False,
        restarted_us: int | None = None,
    ) -> MissionPhase:
        now_us = NOW + round(after_s * S)
        beat_us = now_us if vehicle.heartbeat_us is None else vehicle.heartbeat_us
        seen_us = None if beat_us == UNSEEN_US else beat_us
        situation = Situation(
            vehicle=replace(vehicle, heartbeat_us=seen_us),
            image_us=now_us - round(image_age_s * S),
            holds=() if hold is None else (hold,),
            stop_requested=stop,
            vehicle_silent=silent,
            vehicle_gone=gone,
            restarted_us=restarted_us,
            other_pilot=other,
        )
        self.status, requests = advance(self.status, situation, now_us)
        self.requests += requests
        return self.status.phase
