"""Make training data, train perception and policies, and write model folders.

All of it with `all`, or one step at a time. Whatever is interrupted goes on where it stopped.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from flightstack.arguments.ending import run_command
from flightstack.arguments.parser import OptionParser
from flightstack.libraries import require

PROGRAM = "python -m flightstack.training"
LIBRARIES = ("torch", "pybullet", "joblib", "onnx", "onnxscript", "safetensors", "scipy")
TRAINED = Path("trained")  # never models/, whose weights come with flightstack


def main(arguments: Sequence[str] | None = None, program: str = PROGRAM) -> int:
    """Run one command; returns the exit code."""
    options = build_parser(program).parse_args(arguments)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]

    def run() -> None:
        require("training", *LIBRARIES)
        # Here, not above: --help and a mistyped option must not wait for torch.
        from flightstack.training.commands import steps  # noqa: PLC0415

        steps.run(options)

    return run_command(program, run, interrupted="interrupted; the same command goes on from here")


def build_parser(program: str = PROGRAM) -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = OptionParser(prog=program, description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_all(commands.add_parser("all", help="data, encoders, policies and model folders"))
    _add_data(commands.add_parser("data", help="make one dataset, or look at one"))
    _add_perception(commands.add_parser("perception", help="train one CM-VAE"))
    _add_policy(commands.add_parser("policy", help="train policies on one CM-VAE"))
    _add_calibrate(commands.add_parser("calibrate", help="measure a model's variances anew"))
    _add_detector(commands.add_parser("detector", help="train a detector of sets of gates"))
    _add_assemble(commands.add_parser("assemble", help="a model's folder from finished runs"))
    _add_export(commands.add_parser("export", help="a model's flight form, from its weights"))
    return parser


def _add_detector(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=Path, required=True, help="the model's folder: RECIPE/NAME")
    _add_recipe(parser)
    parser.add_argument(
        "--files",
        type=int,
        choices=range(1, 81),
        metavar="N",
        help="of 40,000 scenes (default: the recipe's, else 2)",
    )
    parser.add_argument("--epochs", type=_count, help="(default: the recipe's, else 5)")
    _add_seed(parser)


def _add_all(parser: argparse.ArgumentParser) -> None:
    _add_recipe(parser)
    _add_training(parser)
    parser.add_argument(
        "--out", type=Path, default=TRAINED, help=f"model folders (default: {TRAINED})"
    )
    parser.add_argument("--runs", type=Path, default=Path("runs"), help="checkpoints, pictures")
    _add_seed(parser)
    parser.add_argument(
        "--data-seed", type=int, help="of the data alone: other trainings on the same data"
    )
    parser.add_argument("--only", nargs="+", default=[], metavar="MODEL", help="for example m0 m4")


def _add_data(parser: argparse.ArgumentParser) -> None:
    kinds = parser.add_subparsers(dest="kind", required=True, metavar="KIND")
    perception = kinds.add_parser("perception", help="images of gates and the nearest one's pose")
    control = kinds.add_parser("control", help="flights and the expert's commands")
    for making in (perception, control):
        making.add_argument("--images", type=_count, required=True)
        making.add_argument("--jobs", type=int, default=-1, help="processes (default: all cores)")
        making.add_argument("--out", type=Path, help="instead of DATA/RECIPE/KIND")
        _add_recipe(making)
        _add_seed(making)
    control.add_argument("--pilot", metavar="MODEL", help="a round of DAgger: this model flies")
    control.add_argument(
        "--pilot-share", type=float, default=0.5, help="of the flights (default: 0.5)"
    )
    labelled = kinds.add_parser("labelled", help="images of yours, with the gate's corners")
    labelled.add_argument("labels", type=Path, help="CSV: image, and four corners in pixels")
    labelled.add_argument(
        "--images", type=Path, help="folder that its paths begin in (default: the CSV's)"
    )
    labelled.add_argument("--out", type=Path, required=True, help="folder of the dataset")
    _add_recipe_alone(labelled)
    look = kinds.add_parser("look", help="draw images with their labels, and histograms")
    look.add_argument("dataset", type=Path, help="its folder")
    look.add_argument("--out", type=Path, help="folder of the pictures (default: DATASET/look)")
    _add_seed(look)


def _add_perception(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--data", type=Path, nargs="+", required=True, help="folders of datasets, read as one"
    )
    parser.add_argument("--start", metavar="MODEL", help="go on from a model, or a finished run")
    parser.add_argument("--out", type=Path, required=True, help="folder of the run")
    parser.add_argument("--encoder", choices=("mcd", "plain"), default="mcd")
    parser.add_argument("--epochs", type=_count, help="instead of the preset's")
    _add_recipe_alone(parser)
    _add_training(parser)
    _add_seed(parser)


def _add_policy(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--data", type=Path, nargs="+", required=True, help="folders of datasets, read as one"
    )
    parser.add_argument("--perception", type=Path, required=True, help="folder of a CM-VAE's run")
    parser.add_argument("--out", type=Path, required=True, help="folder of the run")
    kinds = ("ensemble", "single", "deterministic")
    parser.add_argument("--kind", choices=kinds, default="ensemble")
    parser.add_argument(
        "--bootstrap", action="store_true", default=None, help="each member draws its own data"
    )
    parser.add_argument("--mixture", type=_count, help="Gaussians a member (default: 1)")
    parser.add_argument("--epochs", type=_count, help="instead of the preset's")
    _add_recipe_alone(parser)
    _add_training(parser)
    _add_seed(parser)


def _add_calibrate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", help="by name, for example strong/m0, or its folder")
    parser.add_argument(
        "--out",
        type=Path,
        help="folder of the calibrated model (default: its own, but for those of flightstack)",
    )
    parser.add_argument("--recipe", help="whose flights (default: the one in the model's folder)")
    parser.add_argument(
        "--images", type=int, default=6000, help="of flights over validation tracks (default: 6000)"
    )
    parser.add_argument("--data", type=Path, help="instead: the validation images of control data")
    _add_seed(parser)


def _add_recipe_alone(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--recipe", default="strong", help="strong, paper or a file of yours (default: strong)"
    )


def _add_assemble(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--perception", type=Path, required=True, help="folder of a CM-VAE's run")
    parser.add_argument("--policy", type=Path, required=True, help="folder of the policies' run")
    parser.add_argument(
        "--out", type=Path, required=True, help="the model's folder: RECIPE/NAME, m0 to m4"
    )
    _add_recipe_alone(parser)


def _add_export(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", nargs="+", help="for example strong/m0")


def _add_recipe(parser: argparse.ArgumentParser) -> None:
    _add_recipe_alone(parser)
    parser.add_argument("--data", type=Path, default=Path("data"), help="folder of all data")


def _add_training(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--preset", choices=("quick", "full"), default="quick")
    parser.add_argument("--device", choices=("cpu", "cuda"), default="cpu")


def _add_seed(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seed", type=int, default=0, help="of all chance (default: 0)")


def _count(text: str) -> int:
    """Read a number of at least 1."""
    if not text.isdecimal() or (count := int(text)) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number of 1 or more, got {text!r}")
    return count
