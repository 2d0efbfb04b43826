"""Open what a flight needs: log, link, pilot, vehicle, camera."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from flightstack.camera.address import check_address
from flightstack.camera.camera import AS_IT_COMES, Camera
from flightstack.camera.settings import CameraSettings
from flightstack.clock import VehicleClock
from flightstack.companion.console import Console
from flightstack.companion.guards.limits import FlightLimits
from flightstack.companion.opening.discovery import (
    find_camera,
    listen,
    wait_for_camera,
    wait_for_vehicle,
)
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.mavlink.endpoint import ANY_HOST, Endpoint, Kind
from flightstack.mavlink.link import Link
from flightstack.mavlink.signing import Signing
from flightstack.mavlink.tlog import TlogWriter
from flightstack.mavlink.transport import open_transport

PILOT_BEATS_S = 2.5  # wall time: whoever steers beats once a second
WIDE_ENOUGH = 0.98  # of the networks' view
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


def open_link(
    plan: FlightPlan, tlog: TlogWriter, clock: VehicleClock, stack: contextlib.ExitStack
) -> tuple[VehicleSession, Callable[[], None]]:
    """Open the link to a vehicle; also give what forgets all that has come in until then."""
    signing = None if plan.signing_key is None else Signing(plan.signing_key)
    transport = open_transport(plan.endpoint)
    link = Link(transport, tlog, clock, signing=signing, system=plan.system)
    stack.callback(link.close)
    vehicle = VehicleSession(link, plan.takeoff_altitude_m, publish_members=plan.record_images)
    return vehicle, transport.forget_backlog


def find_vehicle(vehicle: VehicleSession, plan: FlightPlan, console: Console) -> str:
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


def open_its_camera(vehicle: VehicleSession, uri: str, plan: FlightPlan) -> Camera:
    """Open the camera at an address; raises LinkError."""
    camera = wait_for_camera(
        vehicle,
        uri,
        min(plan.timeout_s, CAMERA_OPENS_S),
        trusted=plan.camera is not None,
        settings=plan.camera_settings,
    )
    camera.announced_hz = vehicle.stream_hz if plan.camera is None else None
    return camera


def tell_view(plan: FlightPlan, console: Console) -> None:
    """Warn where the lens is narrower than what the networks look at."""
    view = plan.camera_settings.view
    if view is not None and view.covered_share < WIDE_ENOUGH:
        console.warning(
            f"the lens shows {100 * view.covered_share:.0f} % of the 90 x 90 degrees that the "
            "networks look at: the rest is black"
        )
