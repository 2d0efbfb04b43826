"""Try all that a flight needs and that does not move the vehicle, and say how it is.

Each thing is looked at by itself: one that fails is a line of the table, and those that can be
looked at without it still are. Nothing is armed, no mode is changed, no setpoint is sent.
"""

import contextlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from flightstack.camera.camera import Camera
from flightstack.clock import VehicleClock
from flightstack.companion.console import Console
from flightstack.companion.opening.discovery import listen_until
from flightstack.companion.opening.steps import FlightPlan, find_vehicle, open_its_camera, open_link
from flightstack.companion.piloting.protocols import GuardedPilot
from flightstack.companion.readiness.images import DEFAULT_HZ, ImageSurvey
from flightstack.companion.readiness.parameters import RULES, Rule
from flightstack.companion.readiness.report import Readiness, ReadinessItem, ReadinessLevel
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.errors import FlightstackError
from flightstack.mavlink.motion import MotionHistory
from flightstack.mavlink.parameter_reader import ParameterReader, Value
from flightstack.mavlink.tlog import TlogWriter

Result = TypeVar("Result")
LoadPilot = Callable[[MotionHistory], GuardedPilot]
WATCHED_S = 3.0  # wall time: of the camera and the clock
CLOCK_S = 3.0  # wall time, further
PARAMETERS_S = 5.0  # wall time
ARMABLE_S = 5.0  # wall time: a heartbeat a second
MIN_FREE_BYTES = 500_000_000
MAX_OFFSET_S = 0.005  # how surely the vehicle's clock should be known
GOOD, ODD, BAD = ReadinessLevel.GOOD, ReadinessLevel.ODD, ReadinessLevel.BAD


def check(plan: FlightPlan, load_pilot: LoadPilot, model: str, console: Console) -> Readiness:
    """Look at everything; raises UsageError for options that cannot be, and for nothing else."""
    clock = VehicleClock()
    findings: list[ReadinessItem] = []
    with contextlib.ExitStack() as stack:
        findings.append(_log_folder(plan.log.parent))
        tlog = TlogWriter(plan.log, clock.wall_s)
        stack.callback(tlog.close)
        vehicle, forget_backlog = open_link(plan, tlog, clock, stack)
        pilot = _try(findings, f"model {model}", lambda: load_pilot(vehicle.motion))
        if pilot is not None:
            stack.callback(pilot.close)
        forget_backlog()
        uri = _try(findings, "vehicle and camera", lambda: find_vehicle(vehicle, plan, console))
        if vehicle.link.vehicle is not None:
            findings += _vehicle(vehicle, plan)
            findings += _parameters(vehicle)
        if uri is not None:
            camera = _try(findings, "camera", lambda: open_its_camera(vehicle, uri, plan))
            if camera is not None:
                stack.callback(camera.close)
                findings += _camera(vehicle, camera, uri, plan)
        if pilot is not None:
            findings.append(_speed(pilot, vehicle, model))
    return Readiness(tuple(findings))


def _try(findings: list[ReadinessItem], what: str, action: Callable[[], Result]) -> Result | None:
    try:
        return action()
    except FlightstackError as error:
        findings.append(ReadinessItem(what=what, level=BAD, found=str(error)))
        return None


def _log_folder(folder: Path) -> ReadinessItem:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        free_bytes = shutil.disk_usage(folder).free
    except OSError as error:
        found = f"{folder}: {error.strerror}"
        return ReadinessItem(what="log folder", level=BAD, found=found, wanted="can be written")
    writable = os.access(folder, os.W_OK)
    return ReadinessItem(
        what="log folder",
        level=BAD if not writable else ODD if free_bytes < MIN_FREE_BYTES else GOOD,
        found=f"{folder}, {free_bytes / 1e9:.1f} GB free" if writable else f"{folder}: read only",
        wanted=f"{MIN_FREE_BYTES / 1e9:.1f} GB or more",
    )


def _vehicle(vehicle: VehicleSession, plan: FlightPlan) -> list[ReadinessItem]:
    link = vehicle.link
    listen_until(vehicle, lambda: vehicle.telemetry.armable, ARMABLE_S)
    telemetry, identity = vehicle.telemetry, link.vehicle
    others = [str(each) for each in link.heard if each != identity]
    signs, has_key = identity is not None and identity.signs, plan.signing_key is not None
    return [
        ReadinessItem(what="vehicle", level=GOOD, found=f"PX4, {identity}"),
        *(ReadinessItem(what="others heard", level=ODD, found=each) for each in others),
        ReadinessItem(
            what="signing",
            level=ODD if signs and not has_key else GOOD,
            found=f"{'signed' if signs else 'not signed'}, {'a' if has_key else 'no'} key given",
            wanted="a key where the vehicle signs",
        ),
        ReadinessItem(
            what="arming",
            level=BAD if telemetry.armed else GOOD if telemetry.armable else ODD,
            found="armed" if telemetry.armed else "ready" if telemetry.armable else "not yet",
            wanted="disarmed, and ready to be armed",
        ),
    ]


def _parameters(vehicle: VehicleSession) -> list[ReadinessItem]:
    reader = ParameterReader(vehicle.link, [rule.name for rule in RULES])
    vehicle.parameters = reader
    listen_until(vehicle, lambda: not reader.missing, PARAMETERS_S)
    return [_parameter(rule, reader.values.get(rule.name)) for rule in RULES]


def _parameter(rule: Rule, value: Value | None) -> ReadinessItem:
    return ReadinessItem(
        what=rule.name,
        level=GOOD if value is not None and rule.fits(value) else ODD,
        found="not told" if value is None else f"{value:g}",
        wanted=rule.wanted,
    )


def _camera(
    vehicle: VehicleSession, camera: Camera, uri: str, plan: FlightPlan
) -> list[ReadinessItem]:
    """Watch images for a while, and how well the vehicle's clock is known then."""
    vehicle.timesync.begin()
    watch = ImageSurvey(camera, vehicle.link.clock)
    listen_until(vehicle, watch.look, WATCHED_S, camera)
    listen_until(vehicle, lambda: vehicle.timesync.quality is not None, CLOCK_S)
    if not watch.images:
        why = camera.failure or "no image"
        return [ReadinessItem(what="camera", level=BAD, found=f"{uri}: {why}", wanted="images")]
    announced_hz = vehicle.stream_hz if plan.camera is None else None
    return [
        ReadinessItem(what="camera", level=GOOD, found=uri),
        *watch.findings(plan.camera_settings, announced_hz),
        _clock(vehicle),
    ]


def _clock(vehicle: VehicleSession) -> ReadinessItem:
    quality = vehicle.timesync.quality
    if quality is None:
        return ReadinessItem(
            what="clock",
            level=ODD,
            found="the vehicle does not answer TIMESYNC",
            wanted="an answer",
        )
    return ReadinessItem(
        what="clock",
        level=GOOD if quality.uncertainty_s <= MAX_OFFSET_S else ODD,
        found=f"offset {quality.offset_s:.3f} s within {1e3 * quality.uncertainty_s:.1f} ms, "
        f"round trip {1e3 * quality.round_trip_s:.1f} ms",
        wanted=f"within {1e3 * MAX_OFFSET_S:g} ms",
    )


def _speed(pilot: GuardedPilot, vehicle: VehicleSession, model: str) -> ReadinessItem:
    period_s = 1.0 / (vehicle.stream_hz or DEFAULT_HZ)
    return ReadinessItem(
        what=f"model {model}",
        level=GOOD if pilot.image_s <= period_s else ODD,
        found=f"{1e3 * pilot.image_s:.1f} ms an image",
        wanted=f"{1e3 * period_s:.0f} ms or less",
    )
