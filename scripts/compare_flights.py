"""Show that two commits fly alike, to the last bit: `compare_flights.py COMMIT [COMMIT2]`.

    python scripts/compare_flights.py COMMIT [COMMIT2] [--only NAME ...] [--jobs 2] [--list]

The second commit is by default the working tree. Each flight is flown by each commit's own code,
as real processes that are started from the command line and talked to over real sockets, in
lockstep: by a companion on its courses, in every condition and through each of its phases, and by
scripts through every mode, failsafe, failure and service of the vehicle. Both commits get the same
messages, and every message of both directions is compared: number, order, sequence numbers, every
bit, and the camera's images. The first commit flies each flight twice; what it does not itself
repeat (a stamp of wall time, a port) is named on the flight's line, and left out or, where it is
only shifted, compared from its first value on. Where anything differs, both fly anew, for a busy
machine may disturb a flight. The exit code is 1 if anything still differs.

Not compared are: what hangs on wall time, that is flights that are not in lockstep, lost links, a
companion without images, and the HEARTBEATs that a vehicle repeats while it awaits an answer;
failures of the signal; links by TCP, further links, signatures and video; what the processes print
and the stamps in their logs; files, but for what is fetched over the wire; speed; training and
evaluation. A script's vehicle is compared where it hears what these scripts say, no further.
"""

import argparse
import contextlib
import fnmatch
import signal
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple, Protocol

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from scripts.bench.flying import checked_out  # noqa: E402
from scripts.compare.companion import LOG  # noqa: E402
from scripts.compare.companion_flights import companion_flights  # noqa: E402
from scripts.compare.comparison import compare, learn_all  # noqa: E402
from scripts.compare.failsafe_flights import FAILSAFE_FLIGHTS  # noqa: E402
from scripts.compare.failure_flights import FAILURE_FLIGHTS  # noqa: E402
from scripts.compare.messages import Message  # noqa: E402
from scripts.compare.mode_flights import MODE_FLIGHTS  # noqa: E402
from scripts.compare.pilot import SCRIPT  # noqa: E402
from scripts.compare.service_flights import SERVICE_FLIGHTS  # noqa: E402

ATTEMPTS = 3
CLIENTS = (SCRIPT, f"{LOG} 1/191")  # beginnings of the sources that are not the vehicle's


class Flight(Protocol):
    """What can be flown with the code of any commit."""

    def fly(self, root: Path) -> list[Message]:
        """Fly with the code at `root`; all that was said."""


class Verdict(NamedTuple):
    """What the comparison of one flight came to."""

    equal: bool
    line: str


def all_flights() -> dict[str, Flight]:
    """Give all flights by name, the shortest first."""
    return {
        **SERVICE_FLIGHTS,
        **MODE_FLIGHTS,
        **FAILSAFE_FLIGHTS,
        **FAILURE_FLIGHTS,
        **companion_flights(),
    }


def judge(name: str, flight: Flight, first_root: Path, second_root: Path) -> Verdict:
    """Fly twice with the first code and once with the second, and compare.

    A busy machine disturbs now and then a flight, never each in the same way: where the two codes
    differ, each flies anew, and one flight of the second that equals one of the first is enough.
    """
    ours: list[list[Message]] = []
    theirs: list[list[Message]] = []
    try:
        ours.append(flight.fly(first_root))
        for _ in range(ATTEMPTS):
            ours.append(flight.fly(first_root))
            theirs.append(flight.fly(second_root))
            unrepeated = learn_all(ours)
            found = [compare(one, other, unrepeated) for one in ours for other in theirs]
            if None in found:
                break
    except Exception as error:  # whatever a commit does, the other flights go on
        code = "first" if len(ours) <= len(theirs) + 1 else "second"
        why = " ".join(f"{type(error).__name__}: {error}".split())
        return Verdict(equal=False, line=f"{name}: NOT FLOWN by the {code} commit: {why}")
    equal = None in found
    from_client = sum(message.source.startswith(CLIENTS) for message in ours[0])
    counts = f"{len(ours[0]) - from_client} messages of the vehicle, {from_client} to it"
    attempts = f" at attempt {len(theirs)}" if equal and len(theirs) > 1 else ""
    result = f"equal{attempts}" if equal else f"DIFFERENT: {found[0]}"
    left_out = f" [{unrepeated}]" if str(unrepeated) else ""
    return Verdict(equal=equal, line=f"{name}: {counts}: {result}{left_out}")


def parse_arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="compare_flights.py", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("commit", nargs="?", metavar="COMMIT", help="whose flights count")
    parser.add_argument(
        "second", nargs="?", metavar="COMMIT2", help="what is compared (default: the working tree)"
    )
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", default=["*"], help="flights; * and ? are patterns"
    )
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="flights at once (2)")
    parser.add_argument("--list", action="store_true", help="name all flights")
    options = parser.parse_args(argv)
    if options.commit is None and not options.list:
        parser.error("which commit? or --list")
    return options


def main(argv: Sequence[str] | None = None) -> int:
    """Compare all flights, and print a line for each."""
    options = parse_arguments(argv)
    flights = {
        name: flight
        for name, flight in all_flights().items()
        if any(fnmatch.fnmatchcase(name, pattern) for pattern in options.only)
    }
    if options.list or not flights:
        print("\n".join(flights) or "no such flight; --list names all")
        return 0 if flights else 2
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # tidy up in any case
    begun_s = time.monotonic()
    with contextlib.ExitStack() as stack:
        first = stack.enter_context(checked_out(options.commit))
        second = stack.enter_context(checked_out(options.second)) if options.second else ROOT
        pool = ThreadPoolExecutor(max(1, options.jobs))
        stack.callback(pool.shutdown, cancel_futures=True)
        verdicts = []
        for verdict in pool.map(
            lambda item: judge(item[0], item[1], first, second), flights.items()
        ):
            print(verdict.line, flush=True)
            verdicts.append(verdict)
    different = sum(not verdict.equal for verdict in verdicts)
    elapsed_s = time.monotonic() - begun_s
    print(f"{len(verdicts)} flights, {different} different, in {elapsed_s:.0f} s")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
