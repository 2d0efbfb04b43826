"""Checks of the log itself: losses, damage, clock, and how it ends."""

from flightstack.logs.checks.registry import Level, Verdict, check, graded
from flightstack.logs.flight.flight import Flight

LOSS_WARNING = 0.01
LOSS_ERROR = 0.05
FEW = 20  # messages of a sender, too few to speak of a loss


@check(
    "link_loss",
    title="Link loss",
    meaning="Numbers missing in a sender's sequence. They were lost between the sender and "
    "whoever wrote the log; setpoints on the same link suffer alike.",
)
def link_loss(flight: Flight) -> Verdict:
    """Judge the worst loss of any sender."""
    if not flight.log.is_telemetry:
        return Level.SKIPPED, "the vehicle's own log came over no link"
    many = [loss for loss in flight.log.losses if loss.received >= FEW]
    if not many:
        return Level.SKIPPED, "too few messages"
    senders = [loss for loss in many if loss.is_clear]
    if not senders:
        return Level.SKIPPED, "no sender's numbers are one counter's"
    worst = max(senders, key=lambda loss: loss.fraction)
    reason = f"{worst.fraction:.2%} of {worst.system}/{worst.component} ({worst.lost} messages)"
    return graded(worst.fraction, warning=LOSS_WARNING, error=LOSS_ERROR), reason


@check(
    "file_damage",
    title="File damage",
    meaning="Bytes that are no packet: the file was cut, has holes, or was written by two "
    "programs. Everything with a good checksum was read all the same.",
)
def file_damage(flight: Flight) -> Verdict:
    """Judge what the file has lost."""
    damage = flight.log.damage
    if damage.line_ends:
        lost = f"; {damage.lost_bytes} bytes lost" if damage.lost_bytes else ""
        return Level.WARNING, f"{damage.line_ends}{lost}"
    if not damage.regions:
        return Level.OK, "every byte belongs to a whole record"
    if damage.is_cut and len(damage.regions) == 1:
        return Level.WARNING, f"cut within its last record ({damage.lost_bytes} bytes)"
    places = f"{len(damage.regions)} places" if len(damage.regions) > 1 else "one place"
    first = flight.seconds(damage.regions[0].time_us)
    return Level.WARNING, f"{damage.lost_bytes} bytes lost in {places}, first at {first:.1f} s"


@check(
    "clock",
    title="Clock",
    meaning="Times in the log that run backwards or leap ahead: the writer's clock was set, "
    "or logging paused. Durations across a jump come from the autopilot's own clock, where it "
    "tells one.",
)
def clock(flight: Flight) -> Verdict:
    """Judge jumps of the log's clock."""
    damage = flight.log.damage
    if not damage.has_times:
        return Level.WARNING, "records carry no times; they were taken from the messages"
    if damage.jumps:
        first = damage.jumps[0]
        at_s, jump_s = flight.seconds(first.time_us), first.jump_us * 1e-6
        return Level.WARNING, f"{len(damage.jumps)} jumps, first at {at_s:.1f} s by {jump_s:+.1f} s"
    if damage.mended_times:
        return Level.WARNING, f"{damage.mended_times} damaged times were replaced"
    return Level.OK, "runs evenly"


@check(
    "ending",
    title="How the log ends",
    meaning="A log that ends while the vehicle is under way, or armed, was cut off: by a crash, "
    "a lost link, or a process that died.",
)
def how_it_ends(flight: Flight) -> Verdict:
    """Judge whether the log ends on the ground."""
    if flight.vehicle is None:
        return Level.SKIPPED, "no autopilot in the log"
    is_cut_short = flight.ends_under_way or flight.ends_armed
    return (Level.WARNING if is_cut_short else Level.OK), flight.ending
