"""Each decision's uncertainty, in the order that the wire's document gives."""

import math
from typing import Any

import numpy as np
import pytest

from flightstack.mavlink.uncertainty import UncertaintyPublisher, total_std_m_s
from flightstack.records import ALL_MEMBERS, Decision


def decision(member: list[int], members: int = 5) -> Decision:
    return Decision(
        command=np.array([24.0, 25.0, 26.0, 27.0]),
        aleatoric_std=np.array([0.0, 1.0, 2.0, 3.0]),
        epistemic_std=np.array([4.0, 5.0, 6.0, 7.0]),
        perceptual_std=np.array([8.0, 9.0, 10.0, 11.0]),
        score=np.arange(4.0 * members).reshape(members, 4),
        member=np.array(member),
        modes=np.array([1, 2, 3, 4]),
        member_mean=np.arange(100.0, 100.0 + 4 * members).reshape(members, 4),
    )


def published(*stamps_us: int, member: list[int]) -> list[Any]:
    sent: list[Any] = []
    publisher = UncertaintyPublisher(sent.append)
    for stamp_us in stamps_us:
        publisher.publish(decision(member), stamp_us)
    return sent


def test_rows_stand_in_the_documented_order() -> None:
    sent: list[Any] = []
    UncertaintyPublisher(sent.append).publish(decision([0, 1, 2, 4]), 52_000, 0.25)
    array = sent[0]
    assert (array.name, array.array_id, array.time_usec) == ("decision", 0, 52_000)
    assert array.data[:12] == [float(value) for value in range(12)]
    assert array.data[12:16] == [0.0, 5.0, 10.0, 19.0]
    assert array.data[16:24] == [0, 1, 2, 4, 1, 2, 3, 4]
    assert array.data[24:28] == [24, 25, 26, 27]
    assert array.data[28:] == [0.25, *[0.0] * 29]


def test_pooled_members_have_their_mean_score() -> None:
    array = published(0, member=[ALL_MEMBERS, 0, ALL_MEMBERS, 0])[0]
    assert array.data[12:16] == [8.0, 1.0, 10.0, 3.0]


@pytest.mark.parametrize(("members", "carried"), [(1, 1), (5, 5), (14, 14), (20, 14)])
def test_each_members_prediction_goes_out_on_request(members: int, carried: int) -> None:
    sent: list[Any] = []
    publisher = UncertaintyPublisher(sent.append, with_members=True)
    publisher.publish(decision([0, 0, 0, 0], members), 52_000)
    first, second = sent[:2]
    assert (first.name, first.array_id) == ("decision", 0)
    assert (second.name, second.array_id, second.time_usec) == ("members", 1, 52_000)
    assert second.data[: 4 * carried] == [100.0 + k for k in range(4 * carried)]
    assert second.data[4 * carried :] == [0.0] * (58 - 4 * carried)


def test_members_stay_at_home_unless_requested() -> None:
    sent = published(52_000, member=[0, 0, 0, 0])
    assert [m.name for m in sent if m.get_type() == "DEBUG_FLOAT_ARRAY"] == ["decision"]


def test_plots_get_lengths_at_5_hz() -> None:
    sent = published(*range(0, 1_000_001, 50_000), member=[0, 0, 0, 0])
    named = [message for message in sent if message.get_type() == "NAMED_VALUE_FLOAT"]
    assert {message.name for message in named} == {"unc_alea", "unc_epis", "unc_perc"}
    stamps_ms = [m.time_boot_ms for m in named if m.name == "unc_alea"]
    assert stamps_ms == [0, 200, 400, 600, 800, 1000]
    assert named[0].value == pytest.approx(math.hypot(0, 1, 2))


def test_total_is_the_root_sum_of_squares_of_the_linear_parts() -> None:
    squares = [0, 1, 4, 16, 25, 36, 64, 81, 100]
    assert total_std_m_s(decision([0, 0, 0, 0])) == pytest.approx(math.sqrt(sum(squares)))
