"""Count what sequence numbers say was lost, where they are the numbers of one sender on one link.

A sender counts its packets, modulo 256. But a log may hold a sender by several links; several
programs under one number; several components that share one counter; and a sender that started
again. Each way to tell the numbers apart is tried, and the one that leaves least unexplained is
believed. Where none leaves little, nothing is said of a loss.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog.packets import Packets, tally
from flightstack.mavlink_numbers import LINK_BITS

REORDERED = 128  # a step this far ahead in sequence numbers of 8 bits is a step back
SUSPECT_SHARE = 0.02  # unexplained steps, beyond which other explanations are looked for
BETTER = 0.5  # of what was unexplained: an explanation has to leave less than this
UNCLEAR_SHARE = 0.2  # steps back or repeated, beyond which the numbers are not one counter's
MAX_PROGRAMS = 4  # under one number
FAR_STEP = 24  # a number this far ahead is rather another program's
MIN_PROGRAM = 8  # packets, to count as a program
MAX_SUSPECTS = 6  # senders of a system that are tried two by two
MAX_FOLLOWED = 20_000  # packets of a sender that are told apart one by one

Bytes = NDArray[np.uint8]
Rows = NDArray[np.intp]
Restarts = Sequence[tuple[int, int]]  # between which two packets a system started again


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceLoss:
    """What one sender's sequence numbers tell about the link."""

    system: int
    component: int
    received: int
    lost: int
    repeated: int  # the same sequence number twice in a row
    reordered: int  # steps back: reordering, or two links in one log
    counted: str = "alone"  # by which explanation: see EXPLANATIONS

    @property
    def fraction(self) -> float:
        """Lost over sent, 0 to 1."""
        return self.lost / (self.lost + self.received) if self.received else 0.0

    @property
    def is_clear(self) -> bool:
        """Whether the numbers are one counter's, so that a loss can be told."""
        return self.counted != "unclear"


EXPLANATIONS = {
    "alone": "",
    "by link": "received over several links, each counted for itself",
    "shared": "counted together with other components of its system",
    "programs": "counted apart for several programs under this number",
    "unclear": "its numbers are not one counter's: no loss can be told",
}


@dataclass(frozen=True, slots=True)
class _Steps:
    """What steps of sequence numbers add up to."""

    lost: int = 0
    repeated: int = 0
    reordered: int = 0

    def __add__(self, other: "_Steps") -> "_Steps":
        return _Steps(
            self.lost + other.lost,
            self.repeated + other.repeated,
            self.reordered + other.reordered,
        )

    @property
    def unexplained(self) -> int:
        return self.lost + self.repeated + self.reordered


def _steps(sequence: Bytes, rows: Rows, restarts: Restarts) -> _Steps:
    """Return the steps of one counter at these rows; across a restart nothing is counted."""
    step = np.diff(sequence[rows])  # wraps at 256 as the numbers do
    if restarts:
        later = rows[1:]
        counted = np.ones(len(later), dtype=np.bool_)
        for before, after in restarts:
            counted &= (later <= before) | (rows[:-1] >= after)
        step = step[counted]
    ahead = step[(step > 0) & (step < REORDERED)].astype(np.int64)
    repeated, back = np.count_nonzero(step == 0), np.count_nonzero(step >= REORDERED)
    return _Steps(int((ahead - 1).sum()), int(repeated), int(back))


def _by_link(packets: Packets, rows: Rows, restarts: Restarts) -> _Steps:
    link = packets.time_us[rows] & LINK_BITS
    parts = (rows[link == number] for number in range(LINK_BITS + 1))
    return sum((_steps(packets.sequence, part, restarts) for part in parts), _Steps())


def _programs(sequence: Bytes, rows: Rows) -> list[Rows]:
    """Return the rows of each program under one number: each goes on where it was."""
    last: list[int] = []
    members: list[list[int]] = []
    for row, number in zip(rows.tolist(), sequence[rows].tolist(), strict=True):
        ahead = [(number - before) % 256 or 256 for before in last]
        best = min(range(len(ahead)), key=ahead.__getitem__, default=-1)
        if best < 0 or (ahead[best] > FAR_STEP and len(last) < MAX_PROGRAMS):
            last.append(number)
            members.append([row])
        else:
            last[best] = number
            members[best].append(row)
    return [np.array(each, dtype=np.intp) for each in members]


def _by_program(packets: Packets, rows: Rows, restarts: Restarts) -> _Steps | None:
    parts = _programs(packets.sequence, rows[:MAX_FOLLOWED])
    if len(parts) < 2 or min(map(len, parts)) < MIN_PROGRAM:
        return None
    found = sum((_steps(packets.sequence, part, restarts) for part in parts), _Steps())
    scale = len(rows) / min(len(rows), MAX_FOLLOWED)
    return _Steps(*(round(n * scale) for n in (found.lost, found.repeated, found.reordered)))


def _explained(packets: Packets, rows: Rows, restarts: Restarts) -> tuple[str, _Steps]:
    """Return the best explanation of one sender's numbers by itself, and what it leaves."""
    best, name = _steps(packets.sequence, rows, restarts), "alone"
    by_link = _by_link(packets, rows, restarts)
    if by_link.unexplained < best.unexplained:
        is_needed = best.unexplained > SUSPECT_SHARE * len(rows)
        best, name = by_link, "by link" if is_needed else "alone"
    if best.unexplained > SUSPECT_SHARE * len(rows) and best.reordered:
        apart = _by_program(packets, rows, restarts)
        if apart is not None and apart.unexplained < BETTER * best.unexplained:
            best, name = apart, "programs"
    if best.reordered + best.repeated > UNCLEAR_SHARE * len(rows):
        name = "unclear"
    return name, best


def _together(
    packets: Packets, senders: Mapping[int, Rows], group: Sequence[int], restarts: Restarts
) -> dict[int, _Steps]:
    """Return for senders that share one counter each one's part of the loss; {} if they do not."""
    together = np.sort(np.concatenate([senders[sender] for sender in group]))
    alone = sum((_steps(packets.sequence, senders[each], restarts) for each in group), _Steps())
    shared = _steps(packets.sequence, together, restarts)
    if shared.unexplained >= BETTER * alone.unexplained:
        return {}
    parts = {sender: len(senders[sender]) / len(together) for sender in group}
    return {
        sender: _Steps(*(round(n * part) for n in (shared.lost, shared.repeated, shared.reordered)))
        for sender, part in parts.items()
    }


def _sharing(
    packets: Packets, senders: Mapping[int, Rows], suspects: list[int], restarts: Restarts
) -> dict[int, _Steps]:
    """Return the senders of one system that share a counter, each with its part of the loss.

    Suspects are senders whose own numbers have many gaps; those without gaps count by themselves.
    Where not all of them share one, two of them may.
    """
    if len(suspects) < 2:
        return {}
    every = _together(packets, senders, suspects, restarts)
    if every or len(suspects) > MAX_SUSPECTS:
        return every
    found: dict[int, _Steps] = {}
    pairs = [_together(packets, senders, pair, restarts) for pair in combinations(suspects, 2)]
    for pair in sorted(filter(None, pairs), key=_left):
        if not any(sender in found for sender in pair):
            found |= pair
    return found


def _left(parts: Mapping[int, _Steps]) -> int:
    return sum(steps.unexplained for steps in parts.values())


def find_losses(
    packets: Packets, restarts: Mapping[int, Restarts] | None = None
) -> tuple[SourceLoss, ...]:
    """Return what the sequence numbers of every sender tell, in order of system and component.

    `restarts` tells for each system between which two packets its autopilot started again.
    """
    sender = packets.sender
    rows = {key: np.flatnonzero(sender == key) for key in tally(sender)}
    found: dict[int, tuple[str, _Steps]] = {}
    for system in sorted({key >> 8 for key in rows}):
        again = (restarts or {}).get(system, ())
        mine = {key: each for key, each in rows.items() if key >> 8 == system}
        own = {key: _explained(packets, each, again) for key, each in mine.items()}
        suspects = [
            key
            for key, (_, left) in own.items()
            if left.unexplained > SUSPECT_SHARE * len(mine[key])
        ]
        shared = _sharing(packets, mine, suspects, again)
        found |= own | {key: ("shared", steps) for key, steps in shared.items()}
    return tuple(
        SourceLoss(
            system=key >> 8,
            component=key & 0xFF,
            received=len(rows[key]),
            lost=steps.lost,
            repeated=steps.repeated,
            reordered=steps.reordered,
            counted=name,
        )
        for key, (name, steps) in found.items()
    )
