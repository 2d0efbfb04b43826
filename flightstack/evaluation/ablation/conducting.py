"""Conduct an ablation: find the controls on validation tracks, then fly strategies and controls."""

import argparse
from collections.abc import Sequence
from functools import cache

from flightstack import models
from flightstack.companion.pipeline import load_pipeline
from flightstack.evaluation.ablation.answer import Ablation, answer
from flightstack.evaluation.ablation.design import Point, cube, factorial
from flightstack.evaluation.ablation.pace import (
    FACTORS,
    Control,
    constant,
    find_controls,
    paces,
    validation_tracks,
)
from flightstack.evaluation.ablation.report import ablation_sections
from flightstack.evaluation.experiments.competitors import plain_name
from flightstack.evaluation.experiments.conducting import conduct
from flightstack.evaluation.experiments.experiment import Condition, Experiment, Row, tracks
from flightstack.evaluation.experiments.flying import fly, models_of
from flightstack.evaluation.experiments.folder import CALIBRATION, ROWS, Folder, calibration_folder
from flightstack.evaluation.experiments.options import jobs_of
from flightstack.evaluation.experiments.rows import read_rows
from flightstack.evaluation.ladder.rungs import load_rung
from flightstack.evaluation.pictures.ablation import draw_ablation
from flightstack.evaluation.results.summary import Summary
from flightstack.evaluation.results.writing import write_json

ANSWER_FILE = "ablation.json"
CALIBRATION_LAPS = 1


def ablate(options: argparse.Namespace) -> None:
    """Do as the command asks; raises UsageError, ModelError or UnflownError."""
    best = models.read_config(models.find(options.model) / models.CONFIG_FILE).policy.best_member
    points = factorial(with_best=bool(best)) if options.factorial else cube()
    for point in points:
        load_pipeline(options.model, point.strategy)
    conditions = tuple(load_rung(name)[1] for name in options.rungs)
    test_tracks = tracks(options.tracks, options.seeds)
    controls = _find_controls(points, conditions, options)
    rules = list(dict.fromkeys(control.rule for control in controls.values()))
    strategies = dict.fromkeys([*(point.strategy for point in points), *rules])
    experiment = Experiment(
        name="ablation",
        rows=_rows(options.model, list(strategies)),
        conditions=conditions,
        track_seeds=test_tracks,
        trials=options.trials,
        laps=options.laps,
    )

    @cache
    def found() -> Ablation:
        return answer(read_rows(options.out / ROWS), points, controls)

    def sections(summary: Summary) -> list[str]:
        write_json(options.out / ANSWER_FILE, found())
        return ablation_sections(summary, found(), options.model)

    pairs = [
        (plain_name(one.strategy), plain_name(one.rule))
        for one in controls.values()
        if one.strategy != one.rule
    ]
    conduct(experiment, options, sections, pairs, {"ablation": lambda _: draw_ablation(found())})


def _find_controls(
    points: Sequence[Point], conditions: tuple[Condition, ...], options: argparse.Namespace
) -> dict[str, Control]:
    """Fly strategies and constant factors over validation tracks, and read the controls off."""
    strategies = [point.strategy for point in points]
    flown = list(dict.fromkeys([*strategies, *map(constant, FACTORS)]))
    experiment = Experiment(
        name=CALIBRATION,
        rows=_rows(options.model, flown),
        conditions=conditions,
        track_seeds=validation_tracks(options.validation_tracks),
        trials=1,
        laps=CALIBRATION_LAPS,
    )
    path = calibration_folder(options.out)
    if options.report_only:
        rows = read_rows(path / ROWS)
    else:
        rows = fly(
            experiment,
            Folder(path, experiment, models_of(experiment)),
            jobs=jobs_of(options),
            backend=options.backend,
            keep_logs=False,
        )
    return find_controls(strategies, paces(rows))


def _rows(model: str, strategies: Sequence[str]) -> tuple[Row, ...]:
    return tuple(Row(name=plain_name(name), model=model, strategy=name) for name in strategies)
