from dataclasses import replace

import pytest

from flightstack.errors import UsageError
from flightstack.evaluation.ablation.pace import (
    FACTORS,
    constant,
    find_controls,
    paces,
    validation_tracks,
)
from flightstack.evaluation.trials.rows import TrialRow
from flightstack.training.seeds import TEST_TRACKS
from tests.unit.flightstack.evaluation.made_rows import made_row


def test_controls_are_never_found_on_test_tracks() -> None:
    assert not set(validation_tracks(50)) & set(TEST_TRACKS)
    with pytest.raises(UsageError, match="--validation-tracks must be 1 or more, got 0"):
        validation_tracks(0)


def test_a_pace_is_the_mean_over_the_time_flown() -> None:
    def row(vx_m_s: float, duration_s: float) -> TrialRow:
        return replace(made_row(), strategy="mi-mode", command_vx_m_s=vx_m_s, duration_s=duration_s)

    assert paces([row(1.0, 10.0), row(2.0, 30.0), row(float("nan"), 5.0)]) == {"mi-mode": 1.75}


def test_a_factor_is_read_off_what_constant_factors_flew() -> None:
    flown = {constant(factor): 0.4 + factor for factor in FACTORS}  # no plain product
    controls = find_controls(
        ["de-mean", "mi-mode", "all/mode/same"],
        {**flown, "mi-mode": 1.234, "all/mode/same": 1.401},
    )
    assert (controls["mi-mode"].factor, controls["mi-mode"].rule) == (0.84, "all/mean/slow:0.84")
    assert controls["all/mode/same"].rule == "de-mean"  # as fast, within the step
    assert controls["de-mean"].rule == "de-mean"


def test_chance_that_lets_a_pace_fall_confuses_nothing() -> None:
    flown = {constant(factor): factor for factor in FACTORS} | {constant(0.8): 0.69}
    controls = find_controls(["mi-mode"], {**flown, "mi-mode": 0.85})
    assert 0.8 <= controls["mi-mode"].factor <= 0.9
