"""Checks of the vehicle's own log: what its logger lost."""

from flightstack.logs.checks.registry import Level, Verdict, check
from flightstack.logs.columns.onboard_log import OnboardLog
from flightstack.logs.flight.flight import Flight

LONG_DROPOUT_S = 1.0


@check(
    "dropouts",
    title="Logging dropouts",
    meaning="The logger could not write as fast as the vehicle told, mostly for a slow memory card."
    " Rates, spectra and steps across a dropout are not what the vehicle did.",
)
def dropouts(flight: Flight) -> Verdict:
    """Judge what the vehicle's logger lost, and what is damaged in its file."""
    if not isinstance(flight.log, OnboardLog):
        return Level.SKIPPED, "this is not the vehicle's own log"
    records = flight.log.records
    if not records.dropouts:
        damaged = (Level.WARNING, "none, but pyulog found the file damaged and left parts out")
        return damaged if records.is_damaged else (Level.OK, "none")
    total_s = sum(each.duration_s for each in records.dropouts)
    longest = max(records.dropouts, key=lambda each: each.duration_s)
    at_s = flight.seconds(longest.boot_us + flight.log.boot_offset_us)
    many = f"{len(records.dropouts)} dropouts" if len(records.dropouts) > 1 else "one dropout"
    reason = f"{many}, {total_s:.2f} s in all, longest {longest.duration_s:.2f} s at {at_s:.1f} s"
    return (Level.ERROR if longest.duration_s >= LONG_DROPOUT_S else Level.WARNING), reason
