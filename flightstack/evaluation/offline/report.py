"""Show judgements: tables on the terminal, JSON for machines, pictures for papers."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from flightstack.evaluation.offline.measuring import BAND_M, Judgement
from flightstack.evaluation.offline.predicting import PARTS
from flightstack.libraries import load_pyplot
from flightstack.perception.labels import LABELS
from flightstack.records import VELOCITIES


def print_tables(judged: list[Judgement]) -> None:
    """Print every table."""
    console = Console()
    for table in (_velocities(judged), _poses(judged), _auroc(judged), _decisions(judged)):
        console.print(table)


def write_results(judged: list[Judgement], folder: Path) -> None:
    """Write offline.json, calibration.png and auroc.png."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps([asdict(one) for one in judged], indent=2)
    (folder / "offline.json").write_text(text + "\n")
    _draw_calibration(judged, folder / "calibration.png")
    _draw_auroc(judged, folder / "auroc.png")


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title)
    for column in columns:
        table.add_column(column)
    return table


def _velocities(judged: list[Judgement]) -> Table:
    columns = ("model", "velocity", "NLL", "CRPS", "RMSE", "90 % covers")
    table = _table("Predicted velocities, test tracks (nats, m/s, rad/s)", *columns)
    for one in judged:
        for name in VELOCITIES:
            found = one.velocities[name]
            figures = (f"{found[key]:.3f}" for key in ("nll", "crps", "rmse"))
            table.add_row(one.model, name, *figures, f"{found['coverage90']:.1%}")
    return table


def _poses(judged: list[Judgement]) -> Table:
    band = f"{BAND_M[0]} to {BAND_M[1]} m"
    table = _table("Gate pose, mean absolute error", "model", "label", "all", band, "constant")
    for one in judged:
        for name in LABELS:
            unit, factor = ("m", 1.0) if name.endswith("_m") else ("deg", float(np.degrees(1.0)))
            figures = (f"{value * factor:.2f} {unit}" for value in one.poses[name].values())
            table.add_row(one.model, name.rsplit("_", 1)[0], *figures)
    return table


def _auroc(judged: list[Judgement]) -> Table:
    table = _table(
        "What uncertainty detects, against plain scenes: AUROC", "model", "scene", *PARTS
    )
    for one in judged:
        for kind, found in one.auroc.items():
            table.add_row(one.model, kind, *(f"{found[part]:.2f}" for part in PARTS))
    return table


def _decisions(judged: list[Judgement]) -> Table:
    columns = ("model", "velocity", "several modes: in flight", "double gate", "median", "p90")
    table = _table("Several modes, and how far mi-mode and de-mean differ", *columns)
    for one in judged:
        for k, name in enumerate(VELOCITIES):
            shares = (f"{shares[k]:.1%}" for shares in one.multimodal.values())
            apart = one.strategies_differ[name]
            figures = (f"{apart[key]:.3f}" for key in ("median", "p90"))
            table.add_row(one.model, name, *shares, *figures)
    return table


def _draw_calibration(judged: list[Judgement], path: Path) -> None:
    plt = load_pyplot("evaluation")
    figure, axes = plt.subplots(1, len(VELOCITIES), figsize=(14, 4), layout="constrained")
    for name, plot in zip(VELOCITIES, axes, strict=True):
        plot.plot([0, 1], [0, 1], color="grey", linewidth=0.8)
        for one in judged:
            curve = one.velocities[name]["calibration"]
            plot.plot(curve["levels"], curve["covered"], marker="o", markersize=3, label=one.model)
        plot.set(title=name, xlabel="central interval", aspect="equal")
    axes[0].set_ylabel("share of commands inside")
    axes[0].legend()
    figure.savefig(path, dpi=120)
    plt.close(figure)


def _draw_auroc(judged: list[Judgement], path: Path) -> None:
    plt = load_pyplot("evaluation")
    shape = {"figsize": (10, 3 * len(judged)), "layout": "constrained", "squeeze": False}
    figure, axes = plt.subplots(len(judged), 1, **shape)
    for one, plot in zip(judged, axes[:, 0], strict=True):
        at = np.arange(len(one.auroc))
        for p, part in enumerate(PARTS):
            heights = [found[part] for found in one.auroc.values()]
            plot.bar(at + 0.2 * (p - 1.5), heights, width=0.2, label=part)
        plot.axhline(0.5, color="grey", linewidth=0.8)
        plot.set(title=one.model, ylabel="AUROC", ylim=(0.0, 1.0))
        plot.set_xticks(at, list(one.auroc))
    axes[0, 0].legend(loc="lower right", ncols=len(PARTS))
    figure.savefig(path, dpi=120)
    plt.close(figure)
