"""Time one decision: M0 with the trunk run once, M0 with M full passes one by one, and M1 to M4.

Each is called in turn on the same images in one process on one core. Models that are not committed
run on untrained weights of the right shapes: the time is the same. Prints median and 99th
percentile, the median of the processor's time, and by that the two ratios aimed at: on a busy core
a long decision waits for its neighbours and a short one seldom does, so that ratios of wall time
would flatter.
"""

import argparse
import gc
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from flightstack import models
from flightstack.arrays import Latents, SmallRgb
from flightstack.companion.pipeline import Pipeline
from flightstack.decision.strategies import make_strategy
from flightstack.errors import ModelError
from flightstack.models import Model, ModelConfig
from flightstack.networks.export import export_model
from flightstack.networks.trained import build
from flightstack.perception.config import PerceptionConfig
from flightstack.perception.encoder import Encoder
from flightstack.perception.labels import LabelScale
from flightstack.perception.posterior import (
    LatentPosterior,
    McDropoutPosterior,
    make_posterior,
)
from flightstack.policy.config import PolicyConfig
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.records import Image
from flightstack.tables import table_text
from flightstack.training.models.catalogue import ModelPlan, read_catalogue
from flightstack.training.presets import ENSEMBLE_MEMBERS, MCD_DROPOUT

MIN_SPEED_UP = 6.0  # of M0 over M full passes
MAX_SHARE_OF_M4 = 2.0  # of M4's time, for M0
STRATEGIES = {"m0": "mi-mode"}  # of the others: the catalogue's
Decide = Callable[[Image], object]


class FullPasses:
    """M0's posterior the plain way: the image M times through the whole encoder."""

    def __init__(self, encoder: Encoder, *, samples: int, seed: int) -> None:
        self._one_pass = McDropoutPosterior(encoder, np.random.default_rng(seed), samples=1)
        self._samples = samples

    def sample(self, rgb: SmallRgb) -> Latents:
        """Draw M latent samples (M, Z)."""
        return np.concatenate([self._one_pass.sample(rgb) for _ in range(self._samples)])


def main() -> int:
    """Time, print, and return 1 where an aim is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recipe", default="strong", help="whose models (default: strong)")
    parser.add_argument("--decisions", type=int, default=400, help="of each (default: 400)")
    options = parser.parse_args()
    torch.set_num_threads(1)
    pilots: dict[str, Decide] = {}
    notes: dict[str, str] = {}
    for name, plan in read_catalogue().items():
        model, notes[name] = _model(f"{options.recipe}/{name}", plan)
        strategy = STRATEGIES.get(name, plan.strategy)
        posterior = make_posterior(model.config.perception, model.encoder, seed=0)
        pilots[name] = _pipeline(model, posterior, strategy).decide
        if name == "m0":
            samples = model.config.perception.samples
            naive = FullPasses(model.encoder, samples=samples, seed=0)
            pilots["m0, full passes"] = _pipeline(model, naive, strategy).decide
            notes["m0, full passes"] = f"{samples}, one by one"
    return _report(_time(pilots, options.decisions), notes)


def _model(name: str, plan: ModelPlan) -> tuple[Model, str]:
    try:
        return models.load(name), "trained"
    except ModelError:
        return _untrained_model(plan), "untrained weights"


def _untrained_model(plan: ModelPlan) -> Model:
    rng = np.random.default_rng(0)
    views = rng.integers(0, 256, (4, 64, 64, 3), dtype=np.uint8)
    with tempfile.TemporaryDirectory() as folder:
        trained = build(_untrained(plan))
        config = replace(trained.config, flight=export_model(Path(folder), trained, views))
        (Path(folder) / models.CONFIG_FILE).write_text(table_text(config))
        return models.load(folder)


def _untrained(plan: ModelPlan) -> ModelConfig:
    scale = LabelScale(offset=(0.0,) * 4, scale=(1.0,) * 4)
    return ModelConfig(
        name="untrained",
        recipe="none",
        strategy=plan.strategy,
        weights_sha256="",
        perception=PerceptionConfig(
            latent_dims=10,
            dropout=MCD_DROPOUT if plan.encoder == "mcd" else 0.0,
            sampling=plan.sampling,
            samples=plan.samples,
            label_scale=scale,
        ),
        policy=PolicyConfig(
            members=ENSEMBLE_MEMBERS if plan.policy == "ensemble" else 1,
            probabilistic=plan.policy != "deterministic",
        ),
    )


def _pipeline(model: Model, posterior: LatentPosterior, strategy: str) -> Pipeline:
    limits = model.config.policy.velocity_range
    ensemble = PolicyEnsemble(model.policies, limits, model.config.policy.variance_factor)
    return Pipeline(posterior, ensemble, make_strategy(strategy), limits)


def _time(pilots: dict[str, Decide], decisions: int) -> dict[str, NDArray[np.float64]]:
    """Milliseconds of wall and processor (K, 2), pilots taking turns; the first tenth warms up."""
    rng = np.random.default_rng(0)
    image = Image(stamp_us=0, sequence=0, rgb=np.zeros((64, 64, 3), dtype=np.uint8))
    spent: dict[str, list[tuple[float, float]]] = {name: [] for name in pilots}
    warm_up = decisions // 10
    gc.disable()  # its pauses would hit whoever is on
    for _ in range(warm_up + decisions):
        rgb = rng.integers(0, 256, (64, 64, 3), dtype=np.uint8)
        for name, decide in pilots.items():
            started = time.perf_counter(), time.process_time()
            decide(replace(image, rgb=rgb))
            ended = time.perf_counter(), time.process_time()
            spent[name].append((ended[0] - started[0], ended[1] - started[1]))
    return {name: 1e3 * np.array(times[warm_up:]) for name, times in spent.items()}


def _report(times_ms: dict[str, NDArray[np.float64]], notes: dict[str, str]) -> int:
    table = Table(title="One decision on one core, ms")
    for column in ("model", "median", "99th percentile", "least", "processor, median", ""):
        table.add_column(column)
    for name, times in times_ms.items():
        wall, processor = times.T
        figures = (np.median(wall), np.quantile(wall, 0.99), wall.min(), np.median(processor))
        table.add_row(name, *(f"{figure:.2f}" for figure in figures), notes[name])
    Console().print(table)
    medians = {name: float(np.median(times[:, 1])) for name, times in times_ms.items()}
    speed_up = medians["m0, full passes"] / medians["m0"]
    of_m4 = medians["m0"] / medians["m4"]
    print(f"M0 is {speed_up:.1f} times as fast as full passes (aim: {MIN_SPEED_UP:g} or more)")
    print(f"M0 takes {of_m4:.2f} times as long as M4 (aim: {MAX_SHARE_OF_M4:g} or less)")
    return 0 if speed_up >= MIN_SPEED_UP and of_m4 <= MAX_SHARE_OF_M4 else 1


if __name__ == "__main__":
    raise SystemExit(main())
