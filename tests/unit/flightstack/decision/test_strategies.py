import numpy as np
import pytest

from flightstack.decision.information import gaussian_score, quadrature_score
from flightstack.decision.mixture import pool_mean, split_variance
from flightstack.decision.strategies import STRATEGIES, make_strategy
from flightstack.errors import UsageError
from flightstack.records import ALL_MEMBERS, ActionSamples

VX, VY, VZ, YAW_RATE = range(4)


def make_samples(seed: int = 0) -> ActionSamples:
    rng = np.random.default_rng(seed)
    mean = rng.normal(0.0, 0.2, (5, 32, 4)) + rng.normal(0.0, 0.3, (5, 1, 4))
    return ActionSamples(mean=mean, var=rng.uniform(0.01, 0.2, (5, 32, 4)))


def make_ambiguous(left: float = -0.8, right: float = 0.6) -> ActionSamples:
    """Every member sees a gate on either side: half of its latent samples each."""
    samples = make_samples()
    sides = np.where(np.arange(32) % 2, left, right)
    mean = samples.mean * 0.1 + sides[np.newaxis, :, np.newaxis]
    return ActionSamples(mean=mean, var=samples.var)


def test_de_mean_commands_the_pools_mean() -> None:
    samples = make_samples()
    decision = make_strategy("de-mean").decide(samples)
    np.testing.assert_allclose(decision.command, pool_mean(samples))
    assert (decision.member == ALL_MEMBERS).all()


def test_decision_reports_every_part_of_the_doubt() -> None:
    samples = make_samples()
    decision = make_strategy("mi-mode").decide(samples)
    variances = decision.aleatoric_std**2 + decision.epistemic_std**2 + decision.perceptual_std**2
    np.testing.assert_allclose(variances, split_variance(samples).total)
    np.testing.assert_allclose(decision.score, gaussian_score(samples))


@pytest.mark.parametrize("name", STRATEGIES)
def test_decision_tells_what_each_member_predicts(name: str) -> None:
    samples = make_samples()
    decision = make_strategy(name).decide(samples)
    expected = [[samples.mean[n, :, k].mean() for k in range(4)] for n in range(5)]
    np.testing.assert_allclose(decision.member_mean, expected)


def test_mi_mode_follows_the_member_of_least_score_per_velocity() -> None:
    samples = make_samples()
    decision = make_strategy("mi-mode").decide(samples)
    assert (decision.member == gaussian_score(samples).argmin(axis=0)).all()
    assert decision.command[VX] == samples.mean[decision.member[VX], :, VX].min()


def test_exact_choice_scores_by_quadrature() -> None:
    samples = make_samples()
    decision = make_strategy("mi-exact/mean/same").decide(samples)
    np.testing.assert_allclose(decision.score, quadrature_score(samples))
    expected = [samples.mean[n, :, k].mean() for k, n in enumerate(decision.member)]
    np.testing.assert_allclose(decision.command, expected)


def test_mi_mode_takes_the_left_gate_on_a_clockwise_course() -> None:
    decision = make_strategy("mi-mode").decide(make_ambiguous())
    assert decision.command[[VY, YAW_RATE]] == pytest.approx([-0.8, -0.8], abs=0.15)
    assert (decision.modes == 2).all()


def test_mi_mode_takes_the_right_gate_on_an_anticlockwise_course() -> None:
    decision = make_strategy("mi-mode", direction="ccw").decide(make_ambiguous())
    assert decision.command[[VY, YAW_RATE]] == pytest.approx([0.6, 0.6], abs=0.15)


def test_mirrored_course_mirrors_the_sideways_commands() -> None:
    samples = make_ambiguous()
    mirror = np.array([1.0, -1.0, 1.0, -1.0])
    mirrored = ActionSamples(mean=samples.mean * mirror, var=samples.var)
    clockwise = make_strategy("mi-mode").decide(samples)
    other = make_strategy("mi-mode", direction="ccw").decide(mirrored)
    np.testing.assert_allclose(other.command, clockwise.command * mirror, atol=1e-9)


def test_mi_mode_climbs_and_sinks_softly() -> None:
    decision = make_strategy("mi-mode").decide(make_ambiguous())
    assert decision.command[VZ] == pytest.approx(0.6, abs=0.15)


def test_slow_rule_scales_the_statistic_alone() -> None:
    samples = make_samples()
    plain = make_strategy("de-mean").decide(samples).command
    slow = make_strategy("all/mean/slow").decide(samples).command
    np.testing.assert_allclose(slow, plain * [0.7, 1.0, 1.0, 1.0])


def test_slow_rule_takes_any_factor() -> None:
    samples = make_samples()
    plain = make_strategy("de-mean").decide(samples).command
    slow = make_strategy("all/mean/slow:0.8").decide(samples).command
    np.testing.assert_allclose(slow, plain * [0.8, 1.0, 1.0, 1.0])


def test_without_side_preference_the_densest_mode_is_taken() -> None:
    sides = np.where(np.arange(32) < 10, -0.8, 0.6)  # the fewer see the gate on the left
    noise = make_samples().mean * 0.1
    samples = ActionSamples(mean=noise + sides[:, np.newaxis], var=make_samples().var)
    free = make_strategy("all/mode/same/none").decide(samples).command
    near = make_strategy("all/mode/same/near").decide(samples).command
    assert free == pytest.approx(np.full(4, 0.6), abs=0.15)
    assert near == pytest.approx([0.6, -0.8, 0.6, -0.8], abs=0.15)
    assert make_strategy("all/mode/same").decide(samples).command == pytest.approx(free)


def test_side_preference_leaves_a_single_mode_alone() -> None:
    samples = ActionSamples(mean=make_samples().mean[:1], var=make_samples().var[:1])
    decisions = [
        make_strategy(f"all/mean/same/{side}").decide(samples) for side in ("none", "near")
    ]
    single = decisions[0].modes == 1
    assert single.any()
    assert (decisions[0].command == decisions[1].command)[single].all()


def test_random_choice_follows_its_seed_and_finds_every_member() -> None:
    samples = make_samples()
    first, again, other = (make_strategy("random/mean/same", seed=s) for s in (1, 1, 2))
    chosen = np.stack([first.decide(samples).member for _ in range(40)])
    assert (np.stack([again.decide(samples).member for _ in range(40)]) == chosen).all()
    assert (np.stack([other.decide(samples).member for _ in range(40)]) != chosen).any()
    assert set(chosen.ravel()) == set(range(5))


def test_best_choice_follows_whom_the_model_records() -> None:
    samples = make_samples()
    decision = make_strategy("best/mean/same", best_member=(3, 0, 4, 1)).decide(samples)
    assert decision.member.tolist() == [3, 0, 4, 1]
    expected = [samples.mean[n, :, k].mean() for k, n in enumerate((3, 0, 4, 1))]
    np.testing.assert_allclose(decision.command, expected)


@pytest.mark.parametrize("name", sorted(STRATEGIES))
def test_strategies_are_deterministic(name: str) -> None:
    first, second = (make_strategy(name).decide(make_samples()) for _ in range(2))
    assert (first.command == second.command).all()


@pytest.mark.parametrize("shape", [(1, 1, 4), (5, 1, 4), (1, 32, 4)])
@pytest.mark.parametrize("name", sorted(STRATEGIES))
def test_strategies_take_any_number_of_samples(name: str, shape: tuple[int, int, int]) -> None:
    samples = ActionSamples(mean=np.full(shape, 0.5), var=np.full(shape, 0.01))
    decision = make_strategy(name).decide(samples)
    assert decision.command == pytest.approx(np.full(4, 0.5), abs=1e-6)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mi-mod", "unknown strategy 'mi-mod': choose one of de-mean, mi-mode"),
        ("all/average/same", "unknown statistic 'average'.*mean, median, mode"),
        ("some/mean/same", "unknown member choice 'some'.*all, mi, mi-exact"),
        ("all/mean/fast", "unknown vx rule 'fast'.*same, lowest"),
        ("all/mode/same/left", "unknown side preference 'left'.*none, near"),
        ("all/mean/slow:3", "only 'slow' takes a factor, above 0 and at most 2"),
        ("all/mean/slow:much", "only 'slow' takes a factor"),
        ("all/mean/same:0.5", "only 'slow' takes a factor"),
        ("best/mean/same", "does not record which member is best"),
    ],
)
def test_unknown_names_list_the_known_ones(name: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        make_strategy(name)


def test_unknown_direction_is_refused() -> None:
    with pytest.raises(UsageError, match="unknown direction 'left': choose one of cw, ccw"):
        make_strategy("de-mean", direction="left")
