"""Find the vehicle on the link, and its camera by asking the camera component for its stream.

Where several vehicles are heard, each is asked in turn: the first that names a camera is ours. All
waiting here is in wall time: a vehicle in lockstep has its clock stand still until a camera client
is there.
"""

from collections.abc import Callable

from pymavlink.dialects.v20 import common

from flightstack.camera.camera import AS_IT_COMES, Camera, open_camera
from flightstack.camera.settings import CameraSettings
from flightstack.companion.imaging import ImageQueue
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.companion.waiting import wait_for_any
from flightstack.errors import LinkError
from flightstack.mavlink.commands import CommandSender, request_message
from flightstack.mavlink.identity import VehicleIdentity
from flightstack.mavlink_numbers import CAMERA_COMPONENT

REQUEST_PERIOD_S = 0.5
TURN_S = 2.0  # for one of several vehicles to name its camera
IDLE_S = 0.1
OPEN_S = 5.0  # for one attempt at a camera
SHORTEST_S = 0.1


def wait_for_vehicle(vehicle: VehicleSession, timeout_s: float, *, name: str) -> None:
    """Return once a PX4 vehicle has been heard; raises LinkError after `timeout_s`."""
    link = vehicle.link
    if listen_until(vehicle, lambda: link.vehicle is not None, timeout_s):
        return
    refused = ", ".join(verdict.value for verdict in link.refused)
    why = f"what came was refused: {refused}" if refused else "is it running?"
    if link.heard:
        why = f"looked past: {'; '.join(map(str, link.heard))}"
    raise LinkError(f"no vehicle heard on {name} for {timeout_s:g} s; {why}")


def find_camera(vehicle: VehicleSession, timeout_s: float) -> str:
    """Return the URI of a vehicle's video stream, and have turned to that vehicle.

    Raises LinkError after `timeout_s`.
    """
    request = request_message(common.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION, CAMERA_COMPONENT)
    commands, link = CommandSender(vehicle.link), vehicle.link
    wall_s = link.clock.wall_s
    deadline_s, turn_s = wall_s() + timeout_s, wall_s() + TURN_S
    while wall_s() < deadline_s:
        commands.request(request, 0)
        if listen_until(vehicle, lambda: vehicle.stream_uri is not None, REQUEST_PERIOD_S):
            return str(vehicle.stream_uri)
        if wall_s() >= turn_s and len(link.candidates) > 1:
            turn_s = wall_s() + TURN_S
            vehicle.turn_to(_after(link.vehicle, link.candidates))
    several = len(link.candidates) > 1
    who = f"none of {len(link.candidates)} vehicles" if several else "the vehicle"
    raise LinkError(
        f"{who} named {'a' if several else 'no'} camera stream for {timeout_s:g} s; "
        "name one by --camera URI"
    )


def _after(vehicle: VehicleIdentity | None, candidates: list[VehicleIdentity]) -> VehicleIdentity:
    """Return whose turn it is."""
    at = -1 if vehicle is None else candidates.index(vehicle)
    return candidates[(at + 1) % len(candidates)]


def wait_for_camera(
    vehicle: VehicleSession,
    uri: str,
    timeout_s: float,
    *,
    trusted: bool = True,
    settings: CameraSettings = AS_IT_COMES,
) -> Camera:
    """Open a camera, which may start later than we; raises LinkError after `timeout_s`.

    One that the user has not named is not `trusted`: see `open_camera`.
    """
    clock = vehicle.link.clock
    deadline_s = clock.wall_s() + timeout_s
    while True:
        try:
            left_s = min(OPEN_S, max(SHORTEST_S, deadline_s - clock.wall_s()))
            return open_camera(uri, clock, trusted=trusted, timeout_s=left_s, settings=settings)
        except LinkError:
            if clock.wall_s() >= deadline_s:
                raise
        listen_until(vehicle, lambda: False, REQUEST_PERIOD_S)


def wait_for_image(
    vehicle: VehicleSession, camera: ImageQueue, timeout_s: float, *, name: str
) -> None:
    """Return once an image lies ready; raises LinkError or what the camera is at fault for."""

    def is_ready() -> bool:
        if camera.fault is not None:
            raise camera.fault
        return wait_for_any(0, camera)

    if not listen_until(vehicle, is_ready, timeout_s, camera):
        raise LinkError(f"camera {name} gave no frame for {timeout_s:g} s")


def listen(vehicle: VehicleSession, for_s: float) -> None:
    """Take in what is said for a while."""
    listen_until(vehicle, lambda: False, for_s)


def pace(vehicle: VehicleSession, over_s: float) -> float:
    """Return how much faster than the wall the vehicle's clock runs; 0 where it waits for us."""
    clock = vehicle.link.clock
    began_us, began_s = clock.stamp_us, clock.wall_s()
    listen(vehicle, over_s)
    return max(0, clock.stamp_us - began_us) / 1e6 / (clock.wall_s() - began_s)


def listen_until(
    vehicle: VehicleSession, found: Callable[[], bool], timeout_s: float, *also: ImageQueue
) -> bool:
    """Take in what is said until something is found; whether it was, within `timeout_s`."""
    clock = vehicle.link.clock
    deadline_s = clock.wall_s() + timeout_s
    while not found():
        left_s = deadline_s - clock.wall_s()
        if left_s <= 0:
            return False
        wait_for_any(min(left_s, IDLE_S), vehicle.link, *also)
        vehicle.receive()
        vehicle.keep_up(clock.stamp_us)
        vehicle.link.tlog.flush_if_due()
    return True
