"""Export a model's flight form, looked at by images of its world."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from flightstack import gate_models, models
from flightstack.arrays import RgbStack
from flightstack.files import write_whole
from flightstack.networks.export import export_detector, export_model
from flightstack.networks.trained import load_gate_network, load_trained
from flightstack.tables import table_text
from flightstack.training.data.gate_views import ViewRenderer
from flightstack.training.recipe import Recipe
from flightstack.training.seeds import EXPORT_VIEWS

COMPARED = 64  # images


def export(name: str, report: Callable[[str], None] = print) -> Path:
    """Export a model anew from its weights, and record that in its configuration.

    Raises ModelError where there is no such model, or its graphs say anything else than its
    networks.
    """
    folder = models.find(name)
    images = render_views()
    if gate_models.is_gate_model(name):
        detector_config = gate_models.read_gate_config(folder)
        network = load_gate_network(folder, sha256=detector_config.weights_sha256)
        detector_form = export_detector(folder, network, images)
        text = table_text(replace(detector_config, flight=detector_form))
    else:
        trained = load_trained(name)
        form = export_model(folder, trained, images)
        text = table_text(replace(trained.config, flight=form))
    write_whole(folder / models.CONFIG_FILE, text)
    report(f"{folder.name}: exported; equal on {len(images)} images")
    return folder


def render_views(count: int = COMPARED) -> RgbStack:
    """Render views of gates in the world of the recipe `strong`, the same each time."""
    renderer = ViewRenderer(Recipe.load("strong").views)
    rng = np.random.default_rng(EXPORT_VIEWS)
    try:
        return np.stack([renderer.draw(rng)[0] for _ in range(count)])
    finally:
        renderer.close()
