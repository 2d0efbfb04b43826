"""Split the effect of mi-mode over its three factors, track by track.

A factor's share is what it changes when it is added, averaged over all orders of adding the three:
its Shapley value. The three add up to the whole on every track, so intervals by bootstrap over
tracks hold for shares as for wholes.

Reference: Shapley 1953, "A value for n-person games".
"""

import itertools
from collections.abc import Iterable, Mapping, Sequence

from flightstack.evaluation.ablation.design import FACTORS, PLAIN, Point, corner
from flightstack.evaluation.results.statistics import MeanEstimate, mean_over

ByTrack = Mapping[int, float]


def shares(values: Mapping[Point, ByTrack]) -> dict[str, MeanEstimate]:
    """Split corner(FACTORS) - corner(()) by factor; `values` holds all eight corners by track."""
    orders = list(itertools.permutations(FACTORS))
    steps: dict[str, list[ByTrack]] = {factor: [] for factor in FACTORS}
    for order in orders:
        for count, factor in enumerate(order):
            after, before = values[corner(order[: count + 1])], values[corner(order[:count])]
            steps[factor].append(_minus(after, before))
    return {factor: mean_over(_mean_by_track(own)) for factor, own in steps.items()}


def one_at_a_time(values: Mapping[Point, ByTrack]) -> dict[str, tuple[MeanEstimate, MeanEstimate]]:
    """For each factor: what it adds to de-mean, and what mi-mode loses without it."""
    plain, papers = values[corner(())], values[corner(FACTORS)]
    found = {}
    for factor in FACTORS:
        others = [other for other in FACTORS if other != factor]
        added = mean_over(list(_minus(values[corner([factor])], plain).values()))
        lost = mean_over(list(_minus(papers, values[corner(others)]).values()))
        found[factor] = (added, lost)
    return found


def main_effects(values: Mapping[Point, ByTrack]) -> dict[tuple[str, str], MeanEstimate]:
    """For each level of each factor: what it changes against the plain level, all else averaged."""
    found = {}
    for factor in FACTORS:
        for level in dict.fromkeys(point.levels[factor] for point in values):
            if level == PLAIN[factor]:
                continue
            changed = [point for point in values if point.levels[factor] == level]
            found[factor, level] = mean_over(
                _mean_by_track([_minus(values[p], values[_plain(p, factor)]) for p in changed])
            )
    return found


def _plain(point: Point, factor: str) -> Point:
    return Point.of({**point.levels, factor: PLAIN[factor]})


def _minus(first: ByTrack, second: ByTrack) -> dict[int, float]:
    return {track: first[track] - second[track] for track in sorted(first.keys() & second)}


def _mean_by_track(steps: Sequence[ByTrack]) -> list[float]:
    tracks: Iterable[int] = sorted(set.intersection(*(set(step) for step in steps)))
    return [sum(step[track] for step in steps) / len(steps) for track in tracks]
