"""What the command line's commands do; importing this imports torch."""

import argparse
from dataclasses import replace
from pathlib import Path

import torch

from flightstack import models
from flightstack.errors import UsageError
from flightstack.training.commands import detector
from flightstack.training.commands.all_models import Plan, train_all
from flightstack.training.data.dataset import join, read_dataset
from flightstack.training.data.generation import generate_control, generate_perception
from flightstack.training.data.labelled import read_labelled
from flightstack.training.data.pictures import write_pictures
from flightstack.training.data.piloting import Piloting
from flightstack.training.detector.trainer import DetectorSettings
from flightstack.training.hyperparameters import given
from flightstack.training.models.assemble import write_model
from flightstack.training.models.catalogue import read_catalogue
from flightstack.training.models.flight_form import export
from flightstack.training.models.recalibrate import Labelled, recalibrate
from flightstack.training.perception.start import Start
from flightstack.training.perception.trainer import train_perception
from flightstack.training.policy.trainer import train_policy
from flightstack.training.presets import perception_settings, policy_settings
from flightstack.training.recipe import Recipe
from flightstack.training.runs import read_run

THREADS = 1  # one compute thread a process: two processes beat two threads


def run(options: argparse.Namespace) -> None:
    """Run the command that was parsed."""
    torch.set_num_threads(THREADS)
    if getattr(options, "device", "cpu") == "cuda" and not torch.cuda.is_available():
        raise UsageError("--device cuda: torch finds no CUDA device here; leave the option out")
    commands = {
        "all": _all,
        "data": _data,
        "perception": _perception,
        "policy": _policy,
        "assemble": _assemble,
        "calibrate": _calibrate,
        "detector": _detector,
        "export": _export,
    }
    commands[options.command](options)


def _export(options: argparse.Namespace) -> None:
    for name in options.model:
        export(name)


def _detector(options: argparse.Namespace) -> None:
    recipe = Recipe.load(options.recipe)
    settings = replace(DetectorSettings(seed=options.seed), **given(recipe.training.detector))
    if options.epochs is not None:
        settings = replace(settings, epochs=options.epochs)
    files = options.files or recipe.training.scene_files or detector.FILES
    detector.train(options.out, options.data, recipe, files=files, settings=settings)


def _all(options: argparse.Namespace) -> None:
    train_all(
        Plan(
            recipe=Recipe.load(options.recipe),
            preset=options.preset,
            seed=options.seed,
            data_seed=options.seed if options.data_seed is None else options.data_seed,
            device=options.device,
            data=options.data,
            runs=options.runs,
            models=options.out,
            only=tuple(options.only),
        )
    )


def _data(options: argparse.Namespace) -> None:
    if options.kind == "look":
        write_pictures(options.dataset, options.out or options.dataset / "look", seed=options.seed)
        return
    recipe = Recipe.load(options.recipe)
    if options.kind == "labelled":
        images = options.images or options.labels.parent
        print(f"wrote {read_labelled(options.labels, images, recipe, options.out)}")
        return
    folder = options.out or options.data / recipe.name / options.kind
    common = {"images": options.images, "seed": options.seed, "jobs": options.jobs}
    if options.kind == "perception":
        generate_perception(folder, recipe, **common)
        return
    pilot = options.pilot and Piloting.by(options.pilot, options.pilot_share)
    generate_control(folder, recipe, piloting=pilot, **common)


def _perception(options: argparse.Namespace) -> None:
    settings = perception_settings(
        options.preset,
        encoder=options.encoder,
        seed=options.seed,
        training=Recipe.load(options.recipe).training,
        epochs=options.epochs,
    )
    train_perception(
        join([read_dataset(folder) for folder in options.data]),
        settings,
        options.out,
        device=torch.device(options.device),
        start=Start.find(options.start) if options.start else None,
    )


def _policy(options: argparse.Namespace) -> None:
    settings = policy_settings(
        options.preset,
        kind=options.kind,
        seed=options.seed,
        training=Recipe.load(options.recipe).training,
        epochs=options.epochs,
    )
    if options.bootstrap:
        settings = replace(settings, bootstrap=True)
    if options.mixture is not None:
        settings = replace(settings, mixture=options.mixture)
    perception = read_run(options.perception)
    train_policy(
        join([read_dataset(folder) for folder in options.data]),
        perception.encoder(),
        settings,
        options.out,
        perception=perception.sha256,
        device=torch.device(options.device),
    )


def _assemble(options: argparse.Namespace) -> None:
    known, name = read_catalogue(), options.out.name
    if name not in known:
        raise UsageError(
            f"--out {options.out}: its last folder says which model it is: {', '.join(known)}"
        )
    write_model(
        options.out,
        known[name],
        read_run(options.perception),
        read_run(options.policy),
        recipe=replace(Recipe.load(options.recipe), name=options.out.resolve().parent.name),
        preset="single steps",
    )
    print(f"wrote {options.out}")


def _calibrate(options: argparse.Namespace) -> None:
    folder = models.find(options.model)
    if options.out is None and _came_along(folder):
        raise UsageError(
            f"{options.model} came with flightstack and stays as it is: name a folder for the "
            f"calibrated copy, for example --out trained/{folder.parent.name}/{folder.name}"
        )
    if options.data is not None:
        validation = Labelled.held_out(read_dataset(options.data))
    else:
        config = models.read_config(folder / models.CONFIG_FILE)
        named = options.recipe
        recipe = Recipe.load(named) if named else Recipe.beside(folder, config.recipe)
        validation = Labelled.flown(recipe, images=options.images, seed=options.seed)
    recalibrate(options.model, validation, seed=options.seed, out=options.out)


def _came_along(folder: Path) -> bool:
    """Whether a model's folder is one of those that were published with this package."""
    return any(folder.resolve().is_relative_to(each.resolve()) for each in models.PUBLISHED)
