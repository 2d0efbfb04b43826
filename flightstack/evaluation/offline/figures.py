"""Draw how one ambiguous image becomes doubt: latent densities, then velocities, as in Fig. 3.

Reference: Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation", Fig. 3.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import gaussian_kde, norm

from flightstack import models
from flightstack.evaluation.libraries import load_pyplot
from flightstack.evaluation.offline.predicting import Predictor
from flightstack.evaluation.offline.scenes import DOUBLE_GATE, render_scene
from flightstack.records import VELOCITIES, ActionSamples

LATENT_DRAWS = 32  # times M samples, for smooth latent densities
POINTS = 400
UNITS = ("m/s", "m/s", "m/s", "rad/s")


def draw_ambiguity(name: str, folder: Path, *, seed: int) -> Path:
    """Write `ambiguity.png` for a model; raises ModelError when there is no such model."""
    model = models.load(name)
    image = render_scene(DOUBLE_GATE, 1, seed=seed)[0]
    predictor = Predictor(model, seed=seed)
    samples = predictor.predict(predictor.latents(image))
    z = np.concatenate([predictor.latents(image) for _ in range(LATENT_DRAWS)])
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "ambiguity.png"
    plt = load_pyplot()
    figure = plt.figure(figsize=(16, 8), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(2, 3))
    _draw_seen(left, image, z)
    _draw_velocities(right, samples)
    figure.suptitle(f"{name}: two gates equally near")
    figure.savefig(path, dpi=120)
    plt.close(figure)
    return path


def _draw_seen(figure: Any, image: NDArray[np.uint8], z: NDArray[np.float32]) -> None:
    """Draw the image above the density of every latent dimension."""
    top, bottom = figure.subfigures(2, 1)
    plot = top.subplots()
    plot.imshow(image, interpolation="nearest")
    plot.set_axis_off()
    axes = bottom.subplots(2, (z.shape[1] + 1) // 2, squeeze=False)
    for k, plot in enumerate(axes.flat):
        plot.set_yticks([])
        plot.locator_params(axis="x", nbins=3)
        if k >= z.shape[1]:
            plot.set_axis_off()
            continue
        plot.set_title(f"$z_{k}$", fontsize=9)
        values = z[:, k].astype(np.float64)
        if values.std() < 1e-9:  # one point: a model without doubt about its latents
            plot.axvline(values[0])
            continue
        grid = np.linspace(values.min(), values.max(), POINTS)
        plot.fill_between(grid, gaussian_kde(values)(grid), alpha=0.5)


def _draw_velocities(figure: Any, samples: ActionSamples) -> None:
    """Draw the density of each velocity, for every member and for the pool."""
    axes = figure.subplots(2, 2)
    for k, (name, plot) in enumerate(zip(VELOCITIES, axes.flat, strict=True)):
        mean, std = samples.mean[..., k], np.sqrt(samples.var[..., k])
        grid = np.linspace((mean - 3.0 * std).min(), (mean + 3.0 * std).max(), POINTS)
        densities = norm.pdf(grid[:, np.newaxis, np.newaxis], mean, std).mean(axis=2)  # (G, N)
        for member, density in enumerate(densities.T):
            plot.plot(grid, density, linewidth=1.0, label=f"policy {member}")
        plot.fill_between(grid, densities.mean(axis=1), color="grey", alpha=0.4, label="pool")
        plot.set(xlabel=f"{name}, {UNITS[k]}", yticks=[])
    axes.flat[0].legend(fontsize=8)
