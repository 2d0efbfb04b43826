"""Every input that a fuzzer has found worth keeping is survived again."""

import pytest

from scripts.fuzz import companion_targets, corpus, fuzz, vehicle_targets

TARGETS = companion_targets.TARGETS | vehicle_targets.TARGETS


def test_all_targets_can_be_named() -> None:
    assert tuple(companion_targets.TARGETS) == fuzz.COMPANION
    assert tuple(vehicle_targets.TARGETS) == fuzz.VEHICLE


@pytest.mark.parametrize("name", TARGETS)
def test_the_corpus_is_survived(name: str) -> None:
    inputs = corpus.read(fuzz.SIDES[name], name)
    assert inputs
    for each in inputs:
        TARGETS[name](each)
