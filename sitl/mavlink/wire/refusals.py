"""Count what was refused, and say so at a bounded rate."""

import logging
from collections import Counter
from collections.abc import Iterable
from enum import StrEnum

REPORT_S = 5.0  # wall time between two lines

_log = logging.getLogger(__name__)


class Refusal(StrEnum):
    """Why something that came in changed nothing."""

    NO_PACKET = "no valid packet"
    UNSIGNED = "unsigned"
    BAD_SIGNATURE = "bad signature"
    REPLAYED = "replayed"
    STALE = "signed too long ago"
    FUTURE = "signed in the future"
    CROWDED = "too many signed streams"
    OWN_NAME = "sent in our name"
    KEY_CHANGE = "change of the signing key"
    FILE_ACCESS = "access to a file"
    COMMAND = "command"
    SETPOINT = "setpoint"
    PARAMETER = "parameter"
    PLAN = "plan"


HONEST = {Refusal.COMMAND, Refusal.SETPOINT, Refusal.PARAMETER, Refusal.PLAN}  # mistakes happen


class Refusals:
    """Totals by reason. A flood costs one line in `REPORT_S`, whatever it contains."""

    def __init__(self) -> None:
        self.totals: Counter[Refusal] = Counter()
        self._reported: Counter[Refusal] = Counter()
        self._report_s = -REPORT_S

    def note(self, reasons: Iterable[Refusal]) -> None:
        """Count."""
        self.totals.update(reasons)

    def report(self, now_s: float) -> None:
        """Log what is new, if the last line is long enough ago; `now_s` is wall time."""
        if self.totals == self._reported or now_s - self._report_s < REPORT_S:
            return
        self._report_s = now_s
        fresh = self.totals - self._reported
        level = logging.INFO if HONEST.issuperset(fresh) else logging.WARNING
        _log.log(level, "refused: %s", describe(fresh))
        self._reported = self.totals.copy()

    def report_all(self) -> None:
        """Log the totals, at the end."""
        if self.totals:
            _log.info("refused in all: %s", describe(self.totals))


def describe(counts: Counter[Refusal]) -> str:
    """Spell out counts, the most frequent first."""
    return ", ".join(f"{count} {reason}" for reason, count in counts.most_common())
