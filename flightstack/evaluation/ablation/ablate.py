"""Run an ablation: find the controls on validation tracks, then fly strategies and controls."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache

from flightstack import models
from flightstack.companion.pipeline import load_pipeline
from flightstack.evaluation.ablation.answer import Ablation, answer
from flightstack.evaluation.ablation.design import Point, cube, factorial, points_of
from flightstack.evaluation.ablation.pace import (
    FACTORS,
    Control,
    constant,
    find_controls,
    paces,
    validation_tracks,
)
from flightstack.evaluation.ablation.picture import draw_ablation
from flightstack.evaluation.ablation.report import ablation_sections
from flightstack.evaluation.campaign.folder import CALIBRATION, calibration_folder, read_trials
from flightstack.evaluation.results.summary import ExperimentSummary
from flightstack.evaluation.results.writing import write_json
from flightstack.evaluation.run import fly_missing, run_experiment
from flightstack.evaluation.trials.competitors import plain_name
from flightstack.evaluation.trials.experiment import Competitor, Experiment, tracks
from flightstack.evaluation.trials.request import REQUEST_FILE, held_experiment
from flightstack.evaluation.trials.resume import check_given, resume
from flightstack.evaluation.trials.rows import TrialRow
from flightstack.evaluation.trials.rungs import load_rung

NAME = "ablation"
ANSWER_FILE = "ablation.json"
CALIBRATION_LAPS = 1


def ablate(options: argparse.Namespace) -> None:
    """Do as the command requests; raises UsageError, ModelError or UnflownError.

    Whatever the flights would ask is checked before the first of the calibration.
    """
    if options.report_only:
        experiment = resume(options, NAME, _options_of)
        points = points_of([row.strategy for row in experiment.rows])
        controls = find_controls(_strategies(points), paces(_resume_calibration(options)))
    else:
        points, plain = _request(options)
        controls = find_controls(_strategies(points), paces(_calibrate(plain, options)))
        experiment = replace(plain, rows=_rows(options.model, _with_rules(points, controls)))

    @cache
    def found() -> Ablation:
        return answer(read_trials(options.out, experiment), points, controls)

    def sections(summary: ExperimentSummary) -> list[str]:
        write_json(options.out / ANSWER_FILE, found())
        return ablation_sections(summary, found(), experiment.rows[0].model)

    pairs = [
        (plain_name(one.strategy), plain_name(one.rule))
        for one in controls.values()
        if one.strategy != one.rule
    ]
    run_experiment(
        experiment, options, sections, pairs, {"ablation": lambda _: draw_ablation(found())}
    )


def _request(options: argparse.Namespace) -> tuple[tuple[Point, ...], Experiment]:
    """Return the design, and the experiment as it is before the controls are known."""
    best = models.read_config(models.find(options.model) / models.CONFIG_FILE).policy.best_member
    points = factorial(with_best=bool(best)) if options.factorial else cube()
    for point in points:
        load_pipeline(options.model, point.strategy)
    return points, Experiment(
        name=NAME,
        rows=_rows(options.model, _strategies(points)),
        conditions=tuple(load_rung(name)[1] for name in options.rungs),
        track_seeds=tracks(options.tracks, options.seeds),
        trials=options.trials,
        laps=options.laps,
    )


def _calibrate(plain: Experiment, options: argparse.Namespace) -> list[TrialRow]:
    """Fly strategies and constant factors over validation tracks."""
    strategies = [*(row.strategy for row in plain.rows), *map(constant, FACTORS)]
    experiment = replace(
        plain,
        name=CALIBRATION,
        rows=_rows(options.model, list(dict.fromkeys(strategies))),
        track_seeds=validation_tracks(options.validation_tracks),
        trials=1,
        laps=CALIBRATION_LAPS,
    )
    return fly_missing(experiment, calibration_folder(options.out), options, keep_logs=False)


def _resume_calibration(options: argparse.Namespace) -> list[TrialRow]:
    path = options.out / CALIBRATION
    held = held_experiment(path)
    check_given(options, path / REQUEST_FILE, {"validation_tracks": [len(held.track_seeds)]})
    return read_trials(path, held)


def _options_of(held: Experiment) -> dict[str, list[object]]:
    is_factorial = len(points_of([row.strategy for row in held.rows])) > len(cube())
    return {
        "model": [row.model for row in held.rows],
        "rungs": [condition.name for condition in held.conditions],
        "factorial": [True] if is_factorial else [],
    }


def _strategies(points: Sequence[Point]) -> list[str]:
    return [point.strategy for point in points]


def _with_rules(points: Sequence[Point], controls: Mapping[str, Control]) -> list[str]:
    rules = (control.rule for control in controls.values())
    return list(dict.fromkeys([*_strategies(points), *rules]))


def _rows(model: str, strategies: Sequence[str]) -> tuple[Competitor, ...]:
    return tuple(
        Competitor(name=plain_name(name), model=model, strategy=name) for name in strategies
    )
