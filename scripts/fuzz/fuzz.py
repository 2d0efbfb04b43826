"""Search for an input that a parser does not survive, led by which code each input reaches.

    python scripts/fuzz/fuzz.py TARGET ... [--seconds 60] [--list]
    python scripts/fuzz/fuzz.py all --seconds 20

Each target is fed for so long, from its corpus in tests/corpus, which the suite replays, and which
is left with the fewest inputs that still reach all that has been reached. An input that ends in an
exception, uses more than 2 GB or takes longer than 10 s is told and joins the corpus: what it has
found is to be mended, and stays so. Needs atheris (pip install 'flightstack[fuzz]').
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from scripts.fuzz import corpus  # noqa: E402

COMPANION = (
    *("telemetry", "any-telemetry", "link-bytes", "camera-parts", "camera-picture", "tlog"),
    *("model-config", "addresses"),
)
VEHICLE = (
    *("commands", "parameters", "missions", "files", "any-message", "datagrams"),
    *("camera-requests", "conditions"),
)
SIDES = dict.fromkeys(COMPANION, "companion") | dict.fromkeys(VEHICLE, "vehicle")
MAX_INPUT_BYTES = 2048
MAX_MEMORY_MB = 2048
MAX_INPUT_S = 10
MAX_TOLD = 4000  # characters of what the fuzzer says of a find
INSTRUMENTED = ["flightstack", "sitl", "scripts.fuzz"]


def main() -> int:
    """Fuzz each target in a process of its own; 1 if one has found something."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", metavar="TARGET")
    parser.add_argument("--seconds", type=int, default=60, help="for each target (60)")
    parser.add_argument("--list", action="store_true", help="name the targets, and end")
    options = parser.parse_args()
    if options.list:
        print("\n".join(SIDES))
        return 0
    targets = list(SIDES) if options.targets == ["all"] else options.targets
    unknown = set(targets) - set(SIDES)
    if unknown or not targets:
        parser.error(f"name targets of --list, or all; unknown: {sorted(unknown)}")
    found = [target for target in targets if not search(target, options.seconds)]
    print(f"found something: {', '.join(found)}" if found else "nothing was found")
    return 1 if found else 0


def search(target: str, seconds: int) -> bool:
    """Fuzz one target; whether it has survived. What is worth keeping is kept."""
    side = SIDES[target]
    with tempfile.TemporaryDirectory(prefix="fuzz-") as scratch:
        fed, kept, found = (Path(scratch, name) for name in ("fed", "kept", "found"))
        for folder in (fed, kept, found):
            folder.mkdir()
        before = corpus.read(side, target)
        for number, each in enumerate(before):
            (fed / str(number)).write_bytes(each)
        survived = _run(target, found, f"-max_total_time={seconds}", str(fed))
        if survived:
            merged = _run(target, found, "-merge=1", str(kept), str(fed))
            corpus.write(side, target, _all_of(kept) if merged else before)
        else:
            corpus.write(side, target, before + _all_of(found))
    print(f"{target}: {'survived' if survived else 'FOUND'}", flush=True)
    return survived


def _all_of(folder: Path) -> list[bytes]:
    return [path.read_bytes() for path in folder.iterdir()]


def _run(target: str, found: Path, *arguments: str) -> bool:
    command = [sys.executable, __file__, "--one", target, *arguments]
    limits = (f"-rss_limit_mb={MAX_MEMORY_MB}", f"-timeout={MAX_INPUT_S}")
    places = (f"-max_len={MAX_INPUT_BYTES}", f"-artifact_prefix={found}/", "-verbosity=0")
    told = subprocess.run(
        [*command, *limits, *places], cwd=ROOT, check=False, capture_output=True, text=True
    )
    if told.returncode:
        print(told.stderr[-MAX_TOLD:], file=sys.stderr)
    return told.returncode == 0


def fuzz_one(target: str, arguments: list[str]) -> None:
    """Become the fuzzer of one target; never returns."""
    import atheris  # noqa: PLC0415  (an extra; and the command's own help needs none)

    with atheris.instrument_imports(include=INSTRUMENTED):
        if SIDES[target] == "companion":
            from scripts.fuzz.companion_targets import TARGETS  # noqa: PLC0415
        else:
            from scripts.fuzz.vehicle_targets import TARGETS  # noqa: PLC0415
    again = f"{sys.executable} {__file__} --one {target}"  # how it starts itself, to merge
    atheris.Setup([again, *arguments], TARGETS[target])
    atheris.Fuzz()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        fuzz_one(sys.argv[2], sys.argv[3:])
    sys.exit(main())
