"""Ask what makes the effect of mi-mode: member choice, mode or slow-down; with controls."""

import argparse

from flightstack.evaluation.campaign.options import add_flying_options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the options."""
    add = parser.add_argument
    add("--model", default="paper/m0", help="who flies (default: paper/m0)")
    add(
        *("--rungs",),
        nargs="+",
        default=["level1", "level2"],
        metavar="RUNG",
        help="names or TOML files (default: level1 level2)",
    )
    add("--factorial", action="store_true", help="all levels of all factors, not the corners alone")
    add(
        *("--validation-tracks",),
        type=int,
        default=8,
        metavar="N",
        help="that the controls' pace is found on, one lap each (default: 8)",
    )
    add_flying_options(parser)


def run(options: argparse.Namespace) -> None:
    """Fly what is missing, then write and print the results."""
    # Here, not above: --help must not wait for scipy and torch.
    from flightstack.evaluation.ablation.ablate import ablate  # noqa: PLC0415

    ablate(options)
