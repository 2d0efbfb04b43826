"""Say which version of the code flies: the commit, or the package's version outside a checkout."""

import subprocess
from pathlib import Path

import flightstack

ROOT = Path(flightstack.__file__).parent.parent
FLYING = ("flightstack", "sitl")


def commit() -> str:
    """Name the commit, "+changes" where the code differs from it."""
    try:
        name = _git("rev-parse", "--short=12", "HEAD")
        changed = _git("status", "--porcelain", "--", *FLYING)
    except (OSError, subprocess.CalledProcessError):
        return flightstack.__version__
    return f"{name}+changes" if changed else name


def _git(*arguments: str) -> str:
    command = ["git", "-C", str(ROOT), *arguments]
    done = subprocess.run(  # noqa: S603  fixed words
        command, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()
