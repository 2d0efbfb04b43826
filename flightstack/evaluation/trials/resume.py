"""Take up the experiment that a folder holds, for a report: options may not contradict it.

A report is made of what the folder says, not of what the options would ask for. Options that the
user leaves out say nothing; one that is given must agree, lest a table be told under another name.
"""

import argparse
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from flightstack.errors import UsageError
from flightstack.evaluation.trials.experiment import Experiment
from flightstack.evaluation.trials.request import REQUEST_FILE, held_experiment

Options = Mapping[str, Iterable[object]]  # what each option would have to say


def resume(
    options: argparse.Namespace, name: str, options_of: Callable[[Experiment], Options]
) -> Experiment:
    """Return the experiment of this name in the folder of `--out`.

    `options_of` tells what the command's own options say that ask for it. Raises UsageError where
    the folder holds another kind of experiment, or an option that was given contradicts it.
    """
    held = held_experiment(options.out)
    if held.name != name:
        raise UsageError(f"{options.out} is of a {held.name}, not of a {name}")
    check_given(options, options.out / REQUEST_FILE, {**_shared_options(held), **options_of(held)})
    return held


def check_given(options: argparse.Namespace, path: Path, held: Options) -> None:
    """Raise UsageError where an option that was given says other than the file at `path`."""
    for option, values in held.items():
        known = set(map(str, values))
        if option in options.given and _said(getattr(options, option)) != known:
            raise UsageError(
                f"--{option.replace('_', '-')} contradicts {path}, which says "
                f"{', '.join(sorted(known)) or 'no such thing'}: leave it out"
            )


def _shared_options(held: Experiment) -> Options:
    return {
        "tracks": [len(held.track_seeds)],
        "seeds": [held.track_seeds[0]],
        "trials": [held.trials],
        "laps": [held.laps],
    }


def _said(value: object) -> set[str]:
    return set(map(str, value if isinstance(value, list) else [value]))
