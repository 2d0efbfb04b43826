"""Fly once: open log, link, pilot and camera, run the loop, and sum up."""

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from flightstack.camera.camera import open_camera
from flightstack.clock import VehicleClock
from flightstack.companion.discovery import find_camera, wait_for_frame, wait_for_vehicle
from flightstack.companion.loop import FlightLoop, Pilot
from flightstack.companion.mission_state import Outcome
from flightstack.companion.progress import Progress
from flightstack.companion.reporter import Reporter
from flightstack.companion.signals import landing_first
from flightstack.companion.summary import Summary
from flightstack.companion.vehicle import Vehicle
from flightstack.mavlink.endpoint import Endpoint
from flightstack.mavlink.link import Link
from flightstack.mavlink.tlog import TlogWriter
from flightstack.mavlink.transport import open_transport


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightPlan:
    """What the command line asks for."""

    endpoint: Endpoint
    log: Path
    camera: str | None = None  # None: the one that the vehicle names
    takeoff_altitude_m: float = 3.0  # above home
    duration_s: float | None = None  # in OFFBOARD, vehicle time
    speed_scale: float = 1.0
    timeout_s: float = 60.0  # for vehicle and camera to be found, wall time


def fly(plan: FlightPlan, load_pilot: Callable[[], Pilot], progress: Progress) -> Summary:
    """Fly, and say what happened; raises a FlightstackError where no flight begins."""
    clock = VehicleClock()
    with contextlib.ExitStack() as stack:
        stack.callback(progress.close)
        tlog = TlogWriter(plan.log)
        stack.callback(tlog.close)
        transport = open_transport(plan.endpoint)
        link = Link(transport, tlog, clock)
        stack.callback(link.close)
        vehicle = Vehicle(link, plan.takeoff_altitude_m)
        pilot = load_pilot()
        progress.event(f"waiting for the vehicle on {plan.endpoint}")
        wait_for_vehicle(vehicle, plan.timeout_s, name=str(plan.endpoint))
        uri = plan.camera or find_camera(vehicle, plan.timeout_s)
        progress.event(f"vehicle {link.system_id} found; opening its camera {uri}")
        camera = open_camera(uri, clock)
        stack.callback(camera.close)
        wait_for_frame(vehicle, camera, plan.timeout_s, name=uri)
        loop = FlightLoop(
            vehicle,
            camera,
            pilot,
            Reporter(progress),
            duration_us=None if plan.duration_s is None else round(plan.duration_s * 1e6),
            speed_scale=plan.speed_scale,
        )
        return _run(loop, vehicle, plan)


def _run(loop: FlightLoop, vehicle: Vehicle, plan: FlightPlan) -> Summary:
    clock = vehicle.link.clock
    began_s, began_us = time.monotonic(), clock.stamp_us
    interrupted = False
    try:
        with landing_first(loop.stop):
            loop.run()
    except KeyboardInterrupt:
        interrupted = True
    wall_s = time.monotonic() - began_s
    state, course = loop.state, vehicle.telemetry.course
    ended_us = clock.stamp_us if state.ended_us is None else state.ended_us
    outcome = Outcome.INTERRUPTED if interrupted else state.outcome or Outcome.INTERRUPTED
    return Summary(
        outcome=outcome,
        gates_passed=course.gates_passed,
        gates_total=course.gates_total,
        duration_s=0.0 if state.offboard_us is None else (ended_us - state.offboard_us) / 1e6,
        log=plan.log,
        real_time_factor=(clock.stamp_us - began_us) / 1e6 / wall_s,
        latencies_s=tuple(loop.latencies_s),
        frames=loop.frames,
        setpoints=vehicle.setpoints,
    )
