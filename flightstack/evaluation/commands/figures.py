"""Draw one ambiguous image, its latents, and what every policy says of it (the paper's Fig. 3)."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the options."""
    add = parser.add_argument
    add("--model", default="strong/m0", help="whose (default: strong/m0)")
    add("--out", type=Path, default=Path("figures"), help="folder (default: figures)")
    add("--seed", type=int, default=0, help="of the image and the samples (default: 0)")


def run(options: argparse.Namespace) -> None:
    """Draw, and say where."""
    from flightstack.evaluation.offline.figures import draw_ambiguity  # noqa: PLC0415  torch is slow

    path = draw_ambiguity(options.model, options.out, seed=options.seed)
    print(f"wrote {path}")
