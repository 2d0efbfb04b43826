"""One upload or download of a plan: who it is with, how far it is, and when it is given up.

IDLE --MISSION_COUNT--> UPLOAD --last item, refusal, cancel, 5 s of silence--> IDLE
IDLE --MISSION_REQUEST_LIST--> DOWNLOAD --MISSION_ACK, wrong request, 5 s of silence--> IDLE
"""

from dataclasses import dataclass, field

from sitl.mavlink.servers.request import Request
from sitl.records.missions import MissionItem, MissionResult, Plan, PlanKind

RETRY_US = 250_000  # after this an item is asked for again
ABORT_US = 5_000_000  # of silence; both as PX4 has them


@dataclass(slots=True, kw_only=True)
class Transfer:
    """What both directions have: the partner, and what was last heard and said."""

    kind: PlanKind
    request: Request  # of the partner: where the answers go
    heard_us: int
    sent_us: int
    next: int = 0  # sequence number of the item that is due

    def expect(self, sequence: int) -> None:
        """Let that item be due."""
        self.next = sequence

    def is_with(self, request: Request) -> bool:
        """Whether a message comes from the partner."""
        mine = self.request
        return (mine.system, mine.component) == (request.system, request.component)

    def is_over(self, time_us: int) -> bool:
        """Whether the partner has been silent for too long."""
        return time_us - self.heard_us > ABORT_US


@dataclass(slots=True, kw_only=True)
class Upload(Transfer):
    """A plan that comes in; nobody sees it before it is whole."""

    count: int
    current: int = 0  # the item that was marked as the one to begin with
    items: list[MissionItem] = field(default_factory=list)
    floats: bool = False  # items are asked for by MISSION_REQUEST
    result: MissionResult | None = None  # of the whole plan

    def must_repeat(self, time_us: int) -> bool:
        """Whether the item that is due must be asked for again."""
        return time_us - self.sent_us > RETRY_US

    def take(self, item: MissionItem, *, current: bool) -> bool:
        """Take the item that was due; whether the plan is whole."""
        if current:
            self.current = self.next
        self.items.append(item)
        self.expect(self.next + 1)
        return self.next == self.count


@dataclass(slots=True, kw_only=True)
class Download(Transfer):
    """A plan that goes out, as it was when the download began."""

    plan: Plan

    def give(self, sequence: int) -> MissionItem | None:
        """Give the item that is due, or the last one again; None for any other."""
        if not 0 <= sequence < len(self.plan) or sequence not in (self.next, self.next - 1):
            return None
        self.expect(sequence + 1)
        return self.plan[sequence]
