"""Checks of the vehicle's part: oscillation, estimate jumps, motors, battery, failsafes."""

import numpy as np

from flightstack.logs.checks.registry import Level, Verdict, check, graded
from flightstack.logs.columns.time_axis import measured_us, without_copies
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.outputs import motor_outputs
from flightstack.logs.flight.setpoints import within
from flightstack.logs.flight.vehicle import Interval

OSCILLATION_HZ = (2.0, 12.0)  # slower is flying, faster is vibration that telemetry cannot show
OSCILLATION_RAD_S = 0.35  # root mean square of a rate within that band
MIN_SAMPLES = 64
JUMP_M = 0.5  # more than the velocity explains
JUMP_M_S = 1.5
MOTOR_LIMITS_US = (1005, 1995)  # of SERVO_OUTPUT_RAW while flying
SATURATED_SHARE = 0.02  # of the samples with a motor at its limit
LOW_PERCENT = 20
CRITICAL_PERCENT = 10

NOT_FLYING = (Level.SKIPPED, "the vehicle was never under way")


def _overlap(one: Interval, other: Interval) -> bool:
    return one.start_us < other.end_us and other.start_us < one.end_us


@check(
    "failsafe",
    title="Failsafes",
    meaning="The autopilot said that it was in a failsafe (system status critical or worse), "
    "or that one was activated. The texts around it tell which.",
)
def failsafe(flight: Flight) -> Verdict:
    """Judge whether a failsafe was active."""
    said = [text.text for text in flight.texts if "failsafe" in text.text.lower()]
    spans = flight.failsafes
    armed = [span for span in spans if any(_overlap(span, each) for each in flight.armed)]
    if armed or spans:
        first = (armed or spans)[0]
        at_s = flight.seconds(first.start_us)
        count = len(armed or spans)
        reason = f"{count} times, first at {at_s:.1f} s for {first.duration_s:.1f} s"
        if armed:
            return Level.ERROR, reason
        return Level.WARNING, f"critical or worse while disarmed: {reason}"
    if said:
        return Level.WARNING, f"{said[0]!r}"
    return (Level.OK, "none") if flight.vehicle else (Level.SKIPPED, "no autopilot in the log")


@check(
    "oscillation",
    title="Oscillation",
    meaning="Roll and pitch rates swinging 2 to 12 times a second. It points to gains that "
    "are too high, a loose frame, or a setpoint that itself shakes.",
)
def oscillation(flight: Flight) -> Verdict:
    """Judge the swing of the body rates within a band of frequencies."""
    table = flight.of_vehicle("ATTITUDE")
    table = without_copies(table.take(within(table.time_us, flight.outings)))
    if len(table) < MIN_SAMPLES:
        return Level.SKIPPED, "too little attitude in flight"
    step_s = float(np.median(np.diff(measured_us(table)))) * 1e-6
    if step_s <= 0 or 0.5 / step_s < OSCILLATION_HZ[0]:
        return Level.SKIPPED, "attitude was logged too slowly to see it"
    worst = 0.0
    for name in ("rollspeed", "pitchspeed"):
        rates = table[name].astype(np.float64)
        power = np.abs(np.fft.rfft(rates - rates.mean())) ** 2
        frequency = np.fft.rfftfreq(len(rates), step_s)
        band = (frequency >= OSCILLATION_HZ[0]) & (frequency <= OSCILLATION_HZ[1])
        worst = max(worst, float(np.sqrt(2 * power[band].sum()) / len(rates)))
    reason = f"{worst:.2f} rad/s between {OSCILLATION_HZ[0]:.0f} and {OSCILLATION_HZ[1]:.0f} Hz"
    return graded(worst, warning=OSCILLATION_RAD_S), reason


@check(
    "estimate_jump",
    title="Estimate jumps",
    meaning="The estimated position moved further than the estimated velocity explains: the "
    "estimator reset, or its sensors disagree. Setpoints near a jump are not to be "
    "trusted.",
)
def estimate_jump(flight: Flight) -> Verdict:
    """Judge steps of the position that the velocity does not explain."""
    motion = flight.motion
    flown = within(motion.time_us, flight.outings)
    if np.count_nonzero(flown) < 2:
        return NOT_FLYING
    step_s = np.diff(motion.measured_us[flown]) * 1e-6
    mean_velocity = (motion.velocity_ned[flown][1:] + motion.velocity_ned[flown][:-1]) / 2
    moved = np.diff(motion.position_ned[flown], axis=0)
    soon = (step_s >= 0) & (step_s < 0.5)
    unexplained = np.linalg.norm(moved - mean_velocity * step_s[:, None], axis=1)[soon]
    jumped = np.linalg.norm(np.diff(motion.velocity_ned[flown], axis=0), axis=1)[soon]
    count = int(np.count_nonzero((unexplained > JUMP_M) | (jumped > JUMP_M_S)))
    largest = float(unexplained.max(initial=0.0))
    reason = f"{count} jumps, largest step without velocity {largest:.2f} m"
    return (Level.WARNING if count else Level.OK), reason


@check(
    "motor_saturation",
    title="Motor saturation",
    meaning="A motor at its upper or lower limit cannot give more: the vehicle is too heavy, "
    "the wind too strong, or the manoeuvre too hard, and control is lost for that "
    "moment.",
)
def motor_saturation(flight: Flight) -> Verdict:
    """Judge how often a motor output stands at a limit in flight."""
    table = flight.of_vehicle("SERVO_OUTPUT_RAW")
    motors = motor_outputs(flight)
    if not motors:
        return Level.SKIPPED, "nothing tells which outputs are motors"
    table = table.take(within(table.time_us, flight.outings) & (table["port"] == 0))
    if len(table) < 2:
        return Level.SKIPPED, "no motor outputs in flight"
    outputs = np.stack([table[f"servo{number}_raw"] for number in motors], axis=1)
    low, high = MOTOR_LIMITS_US
    at_limit = ((outputs >= high) | ((outputs <= low) & (outputs > 0))).any(axis=1)
    share = float(at_limit.mean())
    reason = f"a motor at its limit in {share:.1%} of the samples"
    return graded(share, warning=SATURATED_SHARE), reason


@check(
    "battery",
    title="Battery",
    meaning="What was left at the end. Below 20 % land soon; below 10 % the autopilot lands "
    "by itself.",
)
def battery(flight: Flight) -> Verdict:
    """Judge the lowest charge that was reported."""
    known = flight.battery.percent
    if not len(known):
        return Level.SKIPPED, "no charge of a battery in the log"
    lowest = int(known.min())
    reason = f"{lowest} % at the least"
    if lowest < CRITICAL_PERCENT:
        return Level.ERROR, reason
    return (Level.WARNING if lowest < LOW_PERCENT else Level.OK), reason
