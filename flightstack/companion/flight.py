"""Fly once: open log, link, pilot and camera, run the loop, and sum up."""

import contextlib
import gc
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from flightstack.camera.address import check_address
from flightstack.camera.camera import AS_IT_COMES, Camera
from flightstack.camera.recorder import ImageRecorder
from flightstack.camera.settings import CameraSettings
from flightstack.clock import VehicleClock
from flightstack.companion.console import Console
from flightstack.companion.discovery import (
    find_camera,
    listen,
    pace,
    wait_for_camera,
    wait_for_image,
    wait_for_vehicle,
)
from flightstack.companion.guards.limits import FlightLimits
from flightstack.companion.loop import FlightLoop
from flightstack.companion.mission.records import MissionStatus, Outcome
from flightstack.companion.piloting.protocols import GuardedPilot
from flightstack.companion.reporter import Reporter
from flightstack.companion.signals import landing_first
from flightstack.companion.summary import FlightSummary
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.errors import UsageError
from flightstack.mavlink.endpoint import ANY_HOST, Endpoint, Kind
from flightstack.mavlink.link import Link
from flightstack.mavlink.motion import MotionHistory
from flightstack.mavlink.signing import Signing
from flightstack.mavlink.tlog import TlogWriter
from flightstack.mavlink.transport import open_transport

PILOT_BEATS_S = 2.5  # wall time: whoever steers beats once a second
DEFAULT_HZ = 20.0  # of a camera that does not say
PACE_S = 0.5  # wall time: long enough to see a clock run
WIDE_ENOUGH = 0.98  # of the networks' view
TOO_SLOW = 10.0  # times the time between two images
CAMERA_OPENS_S = 5.0  # wall time: it may start when the vehicle does


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightPlan:
    """What the command line asks for."""

    endpoint: Endpoint
    log: Path
    record_images: bool = False  # beside the log
    camera: str | None = None  # None: the one that the vehicle names
    camera_host: str | None = None  # where that may be, beside the vehicle's own host
    camera_settings: CameraSettings = AS_IT_COMES
    takeoff_altitude_m: float = 3.0  # above home
    duration_s: float | None = None  # in OFFBOARD, vehicle time
    gate_timeout_s: float | None = None  # without passing a gate, vehicle time
    lands: bool = True  # at the end
    takes_over: bool = False  # a vehicle that was armed before, or that has a pilot
    reach_s: float = 300.0  # a silent vehicle that we have lifted is called for so long
    speed_scale: float = 1.0
    limits: FlightLimits = field(default_factory=FlightLimits)
    system: int | None = None  # of the vehicle; None: the first that has a camera
    timeout_s: float = 60.0  # for vehicle and camera to be found, wall time
    signing_key: bytes | None = field(default=None, repr=False)


def fly(
    plan: FlightPlan, load_pilot: Callable[[MotionHistory], GuardedPilot], console: Console
) -> FlightSummary:
    """Fly, and say what happened; raises a FlightstackError where no flight begins."""
    clock = VehicleClock()
    reporter = Reporter(console)
    with contextlib.ExitStack() as stack:
        stack.callback(console.close)
        stack.callback(reporter.report_failures)  # of the last writes, too
        tlog = TlogWriter(plan.log, clock.wall_s)
        stack.callback(tlog.close)
        reporter.watch(tlog)
        recorder = _open_recorder(plan, reporter, stack)
        signing = None if plan.signing_key is None else Signing(plan.signing_key)
        transport = open_transport(plan.endpoint)
        link = Link(transport, tlog, clock, signing=signing, system=plan.system)
        stack.callback(link.close)
        vehicle = VehicleSession(link, plan.takeoff_altitude_m, publish_members=plan.record_images)
        pilot = load_pilot(vehicle.motion)
        stack.callback(pilot.close)
        transport.forget_backlog()
        uri = _find(vehicle, plan, console)
        camera = _open_camera(vehicle, uri, plan)
        stack.callback(camera.close)
        reporter.watch(camera)
        _tell_view(plan, console)
        wait_for_image(vehicle, camera, plan.timeout_s, name=uri)
        _check_speed(pilot, vehicle, console)
        loop = FlightLoop(
            vehicle,
            camera,
            pilot,
            reporter,
            mission=_mission(plan),
            speed_scale=plan.speed_scale,
            limits=plan.limits,
            recorder=recorder,
            camera_latency_s=plan.camera_settings.latency_s,
        )
        return _run(loop, vehicle, plan)


def _mission(plan: FlightPlan) -> MissionStatus:
    return MissionStatus(
        duration_us=None if plan.duration_s is None else round(plan.duration_s * 1e6),
        gate_timeout_us=None if plan.gate_timeout_s is None else round(plan.gate_timeout_s * 1e6),
        lands=plan.lands,
        takes_over=plan.takes_over,
        reach_us=round(plan.reach_s * 1e6),
    )


def _open_recorder(
    plan: FlightPlan, reporter: Reporter, stack: contextlib.ExitStack
) -> ImageRecorder | None:
    if not plan.record_images:
        return None
    recorder = ImageRecorder(plan.log.with_suffix(".frames"))
    stack.callback(recorder.close)
    reporter.watch(recorder)
    return recorder


def _find(vehicle: VehicleSession, plan: FlightPlan, console: Console) -> str:
    """Wait for the vehicle; return the URI of its camera, or of the one that was named."""
    console.event(f"waiting for the vehicle on {plan.endpoint}{_openness(plan.endpoint)}")
    wait_for_vehicle(vehicle, plan.timeout_s, name=str(plan.endpoint))
    found = vehicle.link.vehicle
    if found is not None and found.signs and plan.signing_key is None:
        console.warning("the vehicle signs its messages and may heed only such: see --signing-key")
    if vehicle.telemetry.armed:  # by whom? its pilot is heard before we say a word
        listen(vehicle, PILOT_BEATS_S)
    uri = plan.camera
    if uri is None:
        uri = find_camera(vehicle, plan.timeout_s)
        check_address(uri, _vehicle_host(vehicle, plan.endpoint), plan.camera_host)
    if vehicle.link.vehicle != found and vehicle.telemetry.armed:
        listen(vehicle, PILOT_BEATS_S)
    vehicle.link.settle()
    _tell_choice(vehicle.link, uri, console)
    return uri


def _tell_choice(link: Link, uri: str, console: Console) -> None:
    """Say which vehicle is taken, and which were heard and are not."""
    others = [str(each) for each in link.heard if each != link.vehicle]
    past = f"; looked past: {'; '.join(others)} (see --system)" if others else ""
    found = link.vehicle
    at = "" if found is None or found.address is None else " at {}:{}".format(*found.address)
    console.event(f"vehicle {link.system_id} found{at}; opening its camera {uri}{past}")


def _openness(endpoint: Endpoint) -> str:
    """Say who may reach us, where that is everybody."""
    if endpoint.kind is not Kind.UDP_LISTEN or endpoint.host != ANY_HOST:
        return ""
    return f", open to every network; --connect udpin:127.0.0.1:{endpoint.port} for this machine"


def _vehicle_host(vehicle: VehicleSession, endpoint: Endpoint) -> str | None:
    """Say where the vehicle's packets come from; None for a serial line."""
    found = vehicle.link.vehicle
    if found is not None and found.address is not None:
        return found.address[0]
    return endpoint.host if endpoint.kind is Kind.TCP else None


def _open_camera(vehicle: VehicleSession, uri: str, plan: FlightPlan) -> Camera:
    camera = wait_for_camera(
        vehicle,
        uri,
        min(plan.timeout_s, CAMERA_OPENS_S),
        trusted=plan.camera is not None,
        settings=plan.camera_settings,
    )
    camera.announced_hz = vehicle.stream_hz if plan.camera is None else None
    return camera


def _tell_view(plan: FlightPlan, console: Console) -> None:
    """Warn where the lens is narrower than what the networks look at."""
    view = plan.camera_settings.view
    if view is not None and view.covered_share < WIDE_ENOUGH:
        console.warning(
            f"the lens shows {100 * view.covered_share:.0f} % of the 90 x 90 degrees that the "
            "networks look at: the rest is black"
        )


def _check_speed(pilot: GuardedPilot, vehicle: VehicleSession, console: Console) -> None:
    """Say whether the pilot keeps up with the camera; raises UsageError where it never could.

    A vehicle in lockstep waits: there no pilot is too slow.
    """
    period_s = 1.0 / (vehicle.stream_hz or DEFAULT_HZ)
    if pilot.image_s <= period_s:
        return
    times = pilot.image_s * pace(vehicle, PACE_S) / period_s
    words = (
        f"the pilot takes {1000 * pilot.image_s:.0f} ms for an image, {times:.1f} times what the "
        "camera leaves it"
    )
    if times > TOO_SLOW:
        raise UsageError(f"{words}: more than {TOO_SLOW:g} times is not flown")
    if times > 1.0:
        console.warning(f"{words}: decisions will be repeated")


def _run(loop: FlightLoop, vehicle: VehicleSession, plan: FlightPlan) -> FlightSummary:
    gc.freeze()  # libraries and networks stay: no need to look through them again and again
    clock = vehicle.link.clock
    began_s, began_us = clock.wall_s(), clock.stamp_us
    cut_off: Outcome | None = None
    try:
        with landing_first(loop.stop):
            loop.run()
    except KeyboardInterrupt:
        cut_off = Outcome.INTERRUPTED
    except Exception:  # it has been told, at each turn
        cut_off = Outcome.COMPANION_FAILED
    wall_s = clock.wall_s() - began_s
    status, course = loop.status, vehicle.telemetry.course
    ended_us = clock.stamp_us if status.ended_us is None else status.ended_us
    outcome = cut_off or status.outcome or Outcome.INTERRUPTED
    return FlightSummary(
        outcome=outcome,
        gates_passed=course.gates_passed,
        gates_total=course.gates_total,
        duration_s=0.0 if status.offboard_us is None else (ended_us - status.offboard_us) / 1e6,
        log=plan.log,
        real_time_factor=(clock.stamp_us - began_us) / 1e6 / wall_s,
        latencies_s=tuple(loop.latencies_s),
        images=loop.images,
        setpoints=vehicle.setpoints,
    )
