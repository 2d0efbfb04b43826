"""Draw what one ambiguous image makes uncertain: latent densities, then velocities: Fig. 3.

Reference: Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation", Fig. 3.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import gaussian_kde, norm

from flightstack import models
from flightstack.evaluation.offline.predicting import Predictor
from flightstack.evaluation.offline.scenes import DOUBLE_GATE, render_scene
from flightstack.libraries import load_pyplot
from flightstack.records import VELOCITIES, ActionSamples

LATENT_DRAWS = 32  # times M samples, for smooth latent densities
POINTS = 400
UNITS = ("m/s", "m/s", "m/s", "rad/s")
POOL = {"color": "grey", "alpha": 0.4, "label": "pool"}


def draw_ambiguity(name: str, folder: Path, *, seed: int) -> Path:
    """Write `ambiguity.png` for a model; raises ModelError when there is no such model."""
    model = models.load(name)
    image = render_scene(DOUBLE_GATE, 1, seed=seed)[0]
    predictor = Predictor(model, seed=seed)
    samples = predictor.predict(predictor.latents(image))
    z = np.concatenate([predictor.latents(image) for _ in range(LATENT_DRAWS)])
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "ambiguity.png"
    plt = load_pyplot("evaluation")
    figure = plt.figure(figsize=(20, 8), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(2, 4))
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
        _draw_density(plot, z[:, k].astype(np.float64), filled=True, alpha=0.5)


def _draw_velocities(figure: Any, samples: ActionSamples) -> None:
    """Draw each velocity's predicted means above its predictive, for every member and the pool.

    The means are what the paper draws and `mi-mode` takes modes of; the predictive has the noise
    that the policies predict in it.
    """
    axes = figure.subplots(2, len(VELOCITIES))
    for k, (name, unit) in enumerate(zip(VELOCITIES, UNITS, strict=True)):
        means, predictive = axes[:, k]
        for member, values in enumerate(samples.mean[..., k]):
            _draw_density(means, values, label=f"policy {member}", linewidth=1.0)
        _draw_density(means, samples.mean[..., k].ravel(), filled=True, **POOL)
        mean, std = samples.mean[..., k], np.sqrt(samples.var[..., k])
        grid = np.linspace((mean - 3.0 * std).min(), (mean + 3.0 * std).max(), POINTS)
        densities = norm.pdf(grid[:, np.newaxis, np.newaxis], mean, std).mean(axis=2)  # (G, N)
        predictive.plot(grid, densities, linewidth=1.0)
        predictive.fill_between(grid, densities.mean(axis=1), **POOL)
        means.set(title=f"{name}, {unit}: predicted means", yticks=[])
        predictive.set(title=f"{name}, {unit}: predictive", yticks=[])
    axes[0, 0].legend(fontsize=8)


def _draw_density(
    plot: Any, values: NDArray[np.float64], *, filled: bool = False, **style: Any
) -> None:
    """Draw a kernel density of samples, or a line where all are one."""
    if values.std() < 1e-9:
        plot.axvline(values[0], **style)
        return
    reach = 0.2 * np.ptp(values)
    grid = np.linspace(values.min() - reach, values.max() + reach, POINTS)
    draw = plot.fill_between if filled else plot.plot
    draw(grid, gaussian_kde(values)(grid), **style)
