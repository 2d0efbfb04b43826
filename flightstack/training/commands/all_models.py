"""All of it: data, encoders, policies and model folders, whatever of it is not there yet.

Where a recipe asks for DAgger, a first M0 learns from the expert's flights alone and flies others;
then all policies learn from both. What it flies depends on its training, and lies with the runs.
"""

from dataclasses import dataclass
from pathlib import Path

import torch
from joblib import Parallel, delayed

from flightstack.errors import UsageError
from flightstack.training.data.dataset import Dataset, join, read_dataset
from flightstack.training.data.generation import describe, generate_control, generate_perception
from flightstack.training.data.manifest import MANIFEST, refuse_other
from flightstack.training.data.piloting import Piloting
from flightstack.training.models.assemble import write_model
from flightstack.training.models.catalogue import ModelPlan, read_catalogue
from flightstack.training.models.recalibrate import Labelled, recalibrate
from flightstack.training.perception.trainer import train_perception
from flightstack.training.policy.trainer import train_policy
from flightstack.training.presets import (
    calibration_images_of,
    images_of,
    perception_settings,
    policy_settings,
)
from flightstack.training.recipe import Dagger, Recipe
from flightstack.training.runs import perception_folder, policy_folder, read_run

PILOT = "m0"  # who flies DAgger's flights
DAGGER_SEEDS = 1 << 20  # its flights are other ones than the expert's
PROCESSES = 2  # trainings side by side on a CPU, one thread each; an accelerator takes one


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What to train, and where things lie: DATA/RECIPE, RUNS/RECIPE and MODELS/RECIPE."""

    recipe: Recipe
    preset: str
    seed: int
    data_seed: int
    device: str
    data: Path
    runs: Path
    models: Path
    only: tuple[str, ...] = ()  # models to make; none means all

    def dataset(self, kind: str) -> Dataset:
        """Open the data of one kind, "perception" or "control"."""
        return read_dataset(self.data / self.recipe.name / kind)

    def images(self, kind: str) -> int:
        """Say how many images the data of one kind have."""
        return images_of(self.preset, kind, self.recipe.training)

    def catalogue(self) -> dict[str, ModelPlan]:
        """Say which models to make; raises UsageError for a name that is not in models.toml."""
        known = read_catalogue()
        for name in self.only:
            if name not in known:
                raise UsageError(f"unknown model {name!r}: choose from {', '.join(known)}")
        return {name: known[name] for name in self.only or known}

    @property
    def run_folder(self) -> Path:
        """Where this recipe's runs lie."""
        return self.runs / self.recipe.name

    @property
    def dagger_folder(self) -> Path:
        """Where the first M0 lies, its training and its flights."""
        return self.run_folder / f"dagger-{self.seed}"

    def flights(self) -> Dataset:
        """Open what policies learn from: the expert's flights, and with DAgger the first M0's."""
        flights = [self.dataset("control")]
        if self.recipe.dagger:
            flights.append(read_dataset(self.dagger_folder / "control"))
        return join(flights)


class _Stages:
    """Says which of the stages comes now."""

    def __init__(self, count: int) -> None:
        self._count, self._begun = count, 0

    def __call__(self, name: str) -> None:
        """Say it."""
        self._begun += 1
        print(f"stage {self._begun} of {self._count}: {name}")


def train_all(plan: Plan) -> None:
    """Make the data, train the encoders and policies, and write the models' folders.

    What is finished is kept, what was interrupted goes on. Raises UsageError and TrainingError.
    """
    catalogue = plan.catalogue()
    tell = _Stages(5 if plan.recipe.dagger else 4)
    tell("data")
    make_data(plan)
    dagger = plan.recipe.dagger
    steering = {read_catalogue()[PILOT].encoder} if dagger else set()
    encoders = sorted({model.encoder for model in catalogue.values()} | steering)
    stacks = sorted({(model.encoder, model.policy) for model in catalogue.values()})
    processes = Parallel(n_jobs=PROCESSES if plan.device == "cpu" else 1)
    tell("encoders: " + ", ".join(encoders))
    processes(delayed(train_encoder)(plan, encoder) for encoder in encoders)
    if dagger:
        tell(f"flights of a first {PILOT}, which the expert labels")
        fly_dagger(plan, dagger)
    tell("policies: " + ", ".join("-".join(stack) for stack in stacks))
    processes(delayed(train_stack)(plan, *stack) for stack in stacks)
    tell("models: " + ", ".join(catalogue))
    images = calibration_images_of(plan.preset, plan.recipe.training)
    validation = Labelled.flown(plan.recipe, images=images, seed=plan.data_seed)
    for name, model in catalogue.items():
        folder = plan.models / plan.recipe.name / name
        write_model(
            folder,
            model,
            read_run(perception_folder(plan.run_folder, model.encoder, plan.seed)),
            read_run(policy_folder(plan.run_folder, model.encoder, model.policy, plan.seed)),
            recipe=plan.recipe,
            preset=plan.preset,
        )
        recalibrate(str(folder), validation, seed=plan.seed)
        print(f"wrote {folder}")


def make_data(plan: Plan) -> None:
    """Make both datasets, unless they are there; raises UsageError where other ones are."""
    recipe = plan.recipe
    makers = {"perception": generate_perception, "control": generate_control}
    for kind, make in makers.items():
        folder, images = plan.data / recipe.name / kind, plan.images(kind)
        if not (folder / MANIFEST).exists():
            make(folder, recipe, images=images, seed=plan.data_seed)
        refuse_other(folder, describe(kind, recipe, plan.data_seed), {})
        if (count := read_dataset(folder).manifest["count"]) != images:
            raise UsageError(
                f"{folder} holds {count} images, not {images}: choose another --data, or remove it"
            )


def train_encoder(plan: Plan, encoder: str) -> None:
    """Train one encoder in this process."""
    torch.set_num_threads(1)
    train_perception(
        plan.dataset("perception"),
        perception_settings(
            plan.preset,
            encoder=encoder,
            seed=plan.seed,
            training=plan.recipe.training,
        ),
        perception_folder(plan.run_folder, encoder, plan.seed),
        device=torch.device(plan.device),
    )


def train_stack(plan: Plan, encoder: str, policy: str) -> None:
    """Train one stack of policies in this process, from all flights."""
    _train_stack(plan, encoder, policy, plan.flights(), plan.run_folder)


def _train_stack(plan: Plan, encoder: str, policy: str, flights: Dataset, runs: Path) -> None:
    torch.set_num_threads(1)
    perception = read_run(perception_folder(plan.run_folder, encoder, plan.seed))
    train_policy(
        flights,
        perception.encoder(),
        policy_settings(plan.preset, kind=policy, seed=plan.seed, training=plan.recipe.training),
        policy_folder(runs, encoder, policy, plan.seed),
        perception=perception.sha256,
        device=torch.device(plan.device),
    )


def fly_dagger(plan: Plan, dagger: Dagger) -> None:
    """Let an M0 that has learned from the expert alone fly, and the expert label what it sees."""
    pilot, folder = read_catalogue()[PILOT], plan.dagger_folder
    _train_stack(plan, pilot.encoder, pilot.policy, plan.dataset("control"), folder)
    write_model(
        folder / PILOT,
        pilot,
        read_run(perception_folder(plan.run_folder, pilot.encoder, plan.seed)),
        read_run(policy_folder(folder, pilot.encoder, pilot.policy, plan.seed)),
        recipe=plan.recipe,
        preset=plan.preset,
    )
    generate_control(
        folder / "control",
        plan.recipe,
        images=round(dagger.images_share * plan.images("control")),
        seed=DAGGER_SEEDS + plan.data_seed,
        piloting=Piloting.by(str(folder / PILOT), share=1.0),
    )
