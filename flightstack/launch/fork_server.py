"""Fork vehicle and companion from one warm process: what is slow to import is imported once.

`python -m flightstack.launch.fork_server` reads orders from standard input, a line of
JSON each, and flies them one after another; the answer is a line of JSON, too. Each of the two
processes runs the very `main(argv)` that a user runs, with its output in files of the flight's
folder. The flight is over when either has ended: the other is then killed, and so are both when
standard input ends, that is, when whoever gave the orders is gone.
"""

import contextlib
import gc
import importlib
import json
import os
import select
import signal
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any, NoReturn

from flightstack.launch.order import COMPANION, VEHICLE
from flightstack.launch.processes import LIBC, PR_SET_PDEATHSIG

MAINS = {VEHICLE: "sitl.process.cli", COMPANION: "flightstack.companion.cli"}
PRELOADED = (*MAINS.values(), "sitl.process.launch", "sitl.process.assembly")
PRELOADED_LATE = ("flightstack.companion.flight", "flightstack.companion.pipeline")
PR_SET_NAME = 15  # Linux prctl
UNCAUGHT = 1  # exit code of Python after an exception


def main() -> int:
    """Serve until standard input ends."""
    orders, answers = _take_pipes()
    for name in (*PRELOADED, *PRELOADED_LATE):
        importlib.import_module(name)
    gc.freeze()  # so that the children share its memory
    _say(answers, {"ready": True})
    for line in orders:
        _say(answers, _fly(json.loads(line), orders))
    return 0


def _take_pipes() -> tuple[IO[str], IO[str]]:
    """Keep the pipes to ourselves: whatever is printed from now on goes to standard error."""
    orders = os.fdopen(os.dup(0), "r")
    answers = os.fdopen(os.dup(1), "w")
    with Path(os.devnull).open() as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)
    return orders, answers


def _say(answers: IO[str], what: dict[str, Any]) -> None:
    answers.write(json.dumps(what) + "\n")
    answers.flush()


def _fly(order: dict[str, Any], orders: IO[str]) -> dict[str, Any]:
    """Start both, wait for one to end or for the time limit, and leave nothing behind."""
    folder = Path(order["folder"])
    children = {
        name: _start(name, order[name], folder)
        for name in (COMPANION, VEHICLE)  # in this order: the first heartbeat is to be heard
    }
    with contextlib.ExitStack() as stack:
        stack.callback(_kill, children)
        pidfds = {name: os.pidfd_open(pid) for name, pid in children.items()}
        for pidfd in pidfds.values():
            stack.callback(os.close, pidfd)
        ready, _, _ = select.select([*pidfds.values(), orders.fileno()], [], [], order["limit_s"])
        ended = {name: pidfd in ready for name, pidfd in pidfds.items()}
    codes = {name: _status(pid, ended=ended[name]) for name, pid in children.items()}
    if orders.fileno() in ready:  # nobody will order any more
        raise SystemExit(0)
    return codes


def _kill(children: dict[str, int]) -> None:
    for pid in children.values():
        os.kill(pid, signal.SIGKILL)  # not reaped yet: the number is still its own


def _status(pid: int, *, ended: bool) -> int | None:
    """Reap; return its exit code, minus the signal that killed it, or None where we did."""
    _, status = os.waitpid(pid, 0)
    return os.waitstatus_to_exitcode(status) if ended else None


def _start(name: str, arguments: list[str], folder: Path) -> int:
    """Fork one process; returns its id."""
    pid = os.fork()
    if pid == 0:
        _become(name, arguments, folder)
    return pid


def _become(name: str, arguments: list[str], folder: Path) -> NoReturn:
    """Be that process, to its end."""
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    LIBC.prctl(PR_SET_NAME, name.encode())
    for path, number in ((folder / f"{name}.out", 1), (folder / f"{name}.err", 2)):
        with path.open("wb") as file:
            os.dup2(file.fileno(), number)
    os.environ["TMPDIR"] = str(folder)  # a killed process leaves nothing elsewhere
    run: Callable[[list[str]], int] = importlib.import_module(MAINS[name]).main
    code = UNCAUGHT
    try:
        code = run(arguments)
    except SystemExit as error:  # argparse
        code = error.code if isinstance(error.code, int) else 1
    except BaseException:  # this child must never go on as a second server
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


if __name__ == "__main__":
    sys.exit(main())
