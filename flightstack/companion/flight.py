"""Fly once: open log, link, pilot and camera, run the loop, and sum up."""

import contextlib
import gc
from collections.abc import Callable

from flightstack.camera.recorder import ImageRecorder
from flightstack.clock import VehicleClock
from flightstack.companion.console import Console
from flightstack.companion.loop import FlightLoop
from flightstack.companion.mission.records import MissionStatus, Outcome
from flightstack.companion.opening.discovery import (
    pace,
    wait_for_image,
)
from flightstack.companion.opening.steps import (
    FlightPlan,
    find_vehicle,
    open_its_camera,
    open_link,
    tell_view,
)
from flightstack.companion.piloting.protocols import GuardedPilot
from flightstack.companion.reporter import Reporter
from flightstack.companion.signals import landing_first
from flightstack.companion.summary import FlightSummary
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.errors import UsageError
from flightstack.mavlink.motion import MotionHistory
from flightstack.mavlink.tlog import TlogWriter

PILOT_BEATS_S = 2.5  # wall time: whoever steers beats once a second
DEFAULT_HZ = 20.0  # of a camera that does not say
PACE_S = 0.5  # wall time: long enough to see a clock run
WIDE_ENOUGH = 0.98  # of the networks' view
TOO_SLOW = 10.0  # times the time between two images
CAMERA_OPENS_S = 5.0  # wall time: it may start when the vehicle does


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
        vehicle, forget_backlog = open_link(plan, tlog, clock, stack)
        pilot = load_pilot(vehicle.motion)
        stack.callback(pilot.close)
        forget_backlog()
        uri = find_vehicle(vehicle, plan, console)
        camera = open_its_camera(vehicle, uri, plan)
        stack.callback(camera.close)
        reporter.watch(camera)
        tell_view(plan, console)
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
