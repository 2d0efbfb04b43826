"""Judge models on images alone: accuracy, calibration, and what their uncertainty detects."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the options."""
    add = parser.add_argument
    add("--model", nargs="+", default=["strong/m0"], help="one or more (default: strong/m0)")
    add("--images", type=int, default=2000, help="of flights over unseen tracks (default: 2000)")
    add("--scene-images", type=int, default=300, help="of each kind of scene (default: 300)")
    add("--out", type=Path, default=Path("evaluation/offline"), help="folder of the results")
    add("--seed", type=int, default=0, help="of all images and samples (default: 0)")


def run(options: argparse.Namespace) -> None:
    """Judge, print the tables, write JSON and pictures."""
    # Here, not above: --help must not wait for torch.
    from flightstack.evaluation.offline.material import Material, make_material  # noqa: PLC0415
    from flightstack.evaluation.offline.measuring import judge, recipe_of  # noqa: PLC0415
    from flightstack.evaluation.offline.report import print_tables, write_results  # noqa: PLC0415
    from flightstack.libraries import load_library  # noqa: PLC0415
    from flightstack.training.recipe import Recipe  # noqa: PLC0415

    for library in ("scoringrules", "sklearn.metrics", "matplotlib"):
        load_library(library, "evaluation")  # now, not after minutes of work
    recipes = {name: recipe_of(name) for name in options.model}
    made: dict[Recipe, Material] = {
        recipe: make_material(
            recipe, images=options.images, scenes=options.scene_images, seed=options.seed
        )
        for recipe in dict.fromkeys(recipes.values())
    }
    judged = [judge(name, made[recipe], seed=options.seed) for name, recipe in recipes.items()]
    print_tables(judged)
    write_results(judged, options.out)
    print(f"wrote {options.out}")
