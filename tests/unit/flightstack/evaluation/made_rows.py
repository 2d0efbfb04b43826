"""Rows of trials, as a test wants them."""

from dataclasses import replace

from flightstack.evaluation.trials.rows import DEVIATIONS, TrialRow

FIGURES: dict[str, float] = dict.fromkeys(DEVIATIONS, 0.25)
ONE = TrialRow(
    experiment="table",
    row="m0-mean",
    model="paper/m0",
    strategy="de-mean",
    command_factor=1.0,
    condition="level1",
    noise_radius_m=1.0,
    noise_height_m=2.0,
    direction="cw",
    track_seed=1000,
    trial=0,
    seed=7,
    gates_passed=32,
    gates_total=32,
    outcome="finished",
    failed_gate=None,
    failure="",
    duration_s=100.05,
    mean_speed_m_s=1.75,
    command_vx_m_s=1.6,
    multimodal_share=1 / 3,
    retries=0,
    commit="0123456789ab",
    weights_sha256="ab" * 32,
    **FIGURES,
)


def made_row(
    gates: int = 32, *, row: str = "m0-mean", track: int = 1000, trial: int = 0
) -> TrialRow:
    """Make a row that passed so many of 32 gates."""
    whole = gates == ONE.gates_total
    return replace(
        ONE,
        row=row,
        track_seed=track,
        trial=trial,
        gates_passed=gates,
        outcome="finished" if whole else "missed",
        failed_gate=None if whole else gates + 1,
        failure="" if whole else f"Missed gate {gates + 1}: 0.9 m left, 0.1 m low",
    )
