"""Checks of the companion's part: setpoints, images, latency, tracking."""

import numpy as np

from flightstack.logs.checks.registry import Level, Verdict, check, graded
from flightstack.logs.flight.decisions import UNITS, VELOCITIES
from flightstack.logs.flight.flight import Flight

MIN_RATE_HZ = 2.0  # PX4 documents more than 2 Hz for OFFBOARD
GUIDED_LOSS_S = 3.0  # ArduPilot stops a vehicle this long after its last velocity
LOSS_S = 1.0  # PX4 COM_OF_LOSS_T: OFFBOARD is left after this long without a setpoint
STALE_MS = 100.0  # two images at 20 Hz: the setpoint answers what is long past
LATE_MS = 50.0  # one image at 20 Hz
MIN_ANSWERED_SHARE = 0.95
SLOW_RESPONSE_S = 0.5
TRACKING_LIMITS = (0.5, 0.5, 0.5, 0.3)  # m/s, m/s, m/s, rad/s: root mean square
SATURATED_SHARE = 0.2

NOT_SENT = (Level.SKIPPED, "the vehicle's own log does not hold what was sent to it")
NOT_OFFBOARD = (Level.SKIPPED, "nothing was flown in OFFBOARD, or GUIDED")


@check(
    "course",
    title="Course",
    meaning="What the referee of the course said. A course ends at the first gate that is "
    "missed, or at a collision.",
)
def course(flight: Flight) -> Verdict:
    """Judge how the course ended."""
    failure = flight.first_failure
    if failure is not None:
        at_s = flight.seconds(failure.time_us)
        return Level.ERROR, f"{failure.text}, at {at_s:.1f} s, after {flight.gates_passed} gates"
    if not flight.course_events:
        return Level.SKIPPED, "no referee in the log"
    return Level.OK, f"{flight.gates_passed} gates passed, none failed"


@check(
    "setpoint_rate",
    title="Setpoint rate",
    meaning="PX4 leaves OFFBOARD when no setpoint came for 1 s, and wants more than 2 Hz; "
    "ArduPilot in GUIDED stops 3 s after the last velocity. "
    "Gaps mean that the companion stalled, or that the link dropped its setpoints.",
)
def setpoint_rate(flight: Flight) -> Verdict:
    """Judge the gaps between setpoints while OFFBOARD."""
    if not flight.offboard or not flight.log.is_telemetry:
        return NOT_SENT if flight.offboard else NOT_OFFBOARD
    mode = flight.offboard[0].label
    times = flight.offboard_setpoint_times
    if not flight.streams_setpoints:
        return Level.SKIPPED, f"nobody streams setpoints in this log; {mode} was flown without"
    if len(times) < 2:
        return Level.ERROR, f"no setpoints in the log while the vehicle was in {mode}"
    longest_s = float(np.diff(times).max()) * 1e-6
    rate_hz = len(times) / max(sum(span.duration_s for span in flight.offboard), 1e-3)
    reason = f"{rate_hz:.1f} Hz, longest gap {longest_s:.2f} s"
    if mode != "OFFBOARD":
        return graded(longest_s, warning=GUIDED_LOSS_S), f"{mode}: {reason}"
    if longest_s >= LOSS_S or rate_hz < MIN_RATE_HZ:
        return Level.ERROR, reason
    return (Level.WARNING if longest_s > 1 / MIN_RATE_HZ else Level.OK), reason


@check(
    "frames_answered",
    title="Frames answered",
    meaning="Every camera frame should lead to one setpoint. Frames without an answer were "
    "skipped because the decision took too long, or lost on the way.",
)
def frames_answered(flight: Flight) -> Verdict:
    """Judge the share of camera images that were answered."""
    if not flight.answers.images:
        return Level.SKIPPED, "no camera triggers in the log while OFFBOARD"
    answers = flight.answers
    reason = f"{answers.answered} of {answers.images} frames answered ({answers.fraction:.1%})"
    return (Level.OK if answers.fraction >= MIN_ANSWERED_SHARE else Level.WARNING), reason


@check(
    "stale_frames",
    title="Frame-to-setpoint latency",
    meaning="The time from a camera frame to the setpoint that answers it. At 20 Hz a "
    "setpoint more than one frame late steers by an outdated picture.",
)
def stale_frames(flight: Flight) -> Verdict:
    """Judge how late setpoints follow their images."""
    latency_ms = flight.answers.latency_ms
    if not len(latency_ms):
        return Level.SKIPPED, "no setpoint carries the stamp of a camera trigger"
    p50, p99 = np.percentile(latency_ms, (50, 99)).tolist()
    if latency_ms.max() == 0:
        return Level.OK, "no time passes between a frame and its setpoint: flown in lockstep"
    reason = f"median {p50:.1f} ms, 99 % within {p99:.1f} ms"
    return graded(p99, warning=LATE_MS, error=STALE_MS), reason


@check(
    "response_latency",
    title="Setpoint-to-response lag",
    meaning="The shift at which the measured velocity fits the commanded one best. A long lag"
    " means a sluggish controller or a late link; a policy trained with less will "
    "overshoot its turns.",
)
def response_latency(flight: Flight) -> Verdict:
    """Judge the lag of the vehicle's response."""
    known = {
        name: lag
        for name, lag in zip(VELOCITIES, flight.response_lags_s, strict=True)
        if lag is not None
    }
    if not known:
        return Level.SKIPPED, "no velocity changed enough in OFFBOARD to measure a lag"
    reason = ", ".join(f"{name} {lag:.2f} s" for name, lag in known.items())
    return graded(max(known.values()), warning=SLOW_RESPONSE_S), reason


@check(
    "tracking_error",
    title="Tracking error",
    meaning="Root mean square of setpoint minus response while OFFBOARD. Large errors mean "
    "that the vehicle cannot do what is asked: limits, wind, gains, or commands that "
    "jump.",
)
def tracking_error(flight: Flight) -> Verdict:
    """Judge how well the velocities are followed."""
    if not len(flight.tracking):
        return Level.SKIPPED, "no velocity setpoints in OFFBOARD"
    errors = flight.tracking.rms_error().tolist()
    rows = list(zip(VELOCITIES, UNITS, errors, TRACKING_LIMITS, strict=True))
    known = [row for row in rows if np.isfinite(row[2])]
    if not known:
        return Level.SKIPPED, "no velocity of the vehicle in the log"
    reason = ", ".join(f"{name} {error:.2f} {unit}" for name, unit, error, _ in known)
    large = any(error > limit for _, _, error, limit in known)
    return (Level.WARNING if large else Level.OK), reason


@check(
    "command_saturation",
    title="Command saturation",
    meaning="A command that often stands at its largest value is cut off: the policy wants "
    "more than it may have, and what it wants is no longer seen.",
)
def command_saturation(flight: Flight) -> Verdict:
    """Judge how long commands stand at one extreme value."""
    if not flight.log.is_telemetry:
        return NOT_SENT
    commands = flight.tracking.setpoint
    if len(commands) < 20:
        return Level.SKIPPED, "too few velocity setpoints in OFFBOARD"
    shares = {}
    for name, column in zip(VELOCITIES, commands.T, strict=True):
        values = np.abs(column[np.isfinite(column)])
        if len(values) and values.max() > 0 and np.ptp(values) > 0:
            exactly = np.isclose(values, values.max(), rtol=1e-5)
            shares[name] = float(exactly.mean())
    worst = max(shares, key=lambda name: shares[name], default=None)
    if worst is None:
        return Level.SKIPPED, "no command changes"
    reason = f"{worst} stands at its largest value in {shares[worst]:.0%} of the setpoints"
    return graded(shares[worst], warning=SATURATED_SHARE), reason
