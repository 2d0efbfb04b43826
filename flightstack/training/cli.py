"""The command line of the training: data, perception, policy, or all of it.

Torch is imported by the command that needs it: `--help` is instant.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from flightstack.errors import FlightstackError

THREADS = 1  # one compute thread a process: two processes beat two threads


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    options = _parser().parse_args(arguments)
    os.environ.setdefault("OMP_NUM_THREADS", str(THREADS))
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    try:
        options.run(options)
    except FlightstackError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("interrupted: the same command goes on from the last epoch", file=sys.stderr)
        return 130
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m flightstack.training", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    perception = commands.add_parser("perception", help="train one CM-VAE")
    perception.add_argument("--data", type=Path, required=True, help="folder of a dataset")
    perception.add_argument("--out", type=Path, required=True, help="folder of the run")
    perception.add_argument(
        "--encoder", choices=("mcd", "plain"), default="mcd", help="with or without dropout"
    )
    perception.add_argument("--epochs", type=int, help="instead of the preset's")
    _add_common(perception)
    perception.set_defaults(run=_run_perception)
    return parser


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--preset", choices=("quick", "full"), default="quick")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--device", choices=("cpu", "cuda"), default="cpu")


def _run_perception(options: argparse.Namespace) -> None:
    import torch  # noqa: PLC0415

    from flightstack.training.dataset import read_dataset  # noqa: PLC0415
    from flightstack.training.perception import train_perception  # noqa: PLC0415
    from flightstack.training.presets import perception_settings  # noqa: PLC0415

    torch.set_num_threads(THREADS)
    settings = perception_settings(
        options.preset, encoder=options.encoder, seed=options.seed, epochs=options.epochs
    )
    train_perception(
        read_dataset(options.data), settings, options.out, device=torch.device(options.device)
    )
