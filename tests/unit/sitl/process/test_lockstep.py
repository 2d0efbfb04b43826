import logging

import pytest

from sitl.process.lockstep import PATIENCE_S, Lockstep

IMAGE_US = 52_000


def started() -> Lockstep:
    lockstep = Lockstep()
    lockstep.image_published(0, 0.0)
    lockstep.setpoint_received(0, has_viewers=True)
    return lockstep


def test_time_stands_at_image_0_until_a_viewer_has_answered_it() -> None:
    lockstep = Lockstep()
    lockstep.image_published(0, 0.0)
    assert not lockstep.may_advance(3600.0, has_viewers=False)
    assert not lockstep.may_advance(3600.0, has_viewers=True)
    lockstep.setpoint_received(0, has_viewers=False)  # somebody who sees no images
    assert not lockstep.may_advance(3600.0, has_viewers=True)
    lockstep.setpoint_received(0, has_viewers=True)
    assert lockstep.may_advance(3600.0, has_viewers=True)
    assert not lockstep.is_free


def test_time_runs_to_the_next_image_and_stands_there_until_it_is_answered() -> None:
    lockstep = started()
    assert lockstep.may_advance(0.1, has_viewers=True)
    lockstep.image_published(IMAGE_US, 0.1)
    assert not lockstep.may_advance(0.2, has_viewers=True)
    lockstep.setpoint_received(IMAGE_US, has_viewers=True)
    assert lockstep.may_advance(0.3, has_viewers=True)


def test_an_answer_to_an_older_image_does_not_count() -> None:
    lockstep = started()
    lockstep.image_published(IMAGE_US, 0.1)
    lockstep.setpoint_received(IMAGE_US - 1000, has_viewers=True)
    assert not lockstep.may_advance(0.2, has_viewers=True)


def test_an_answer_counts_for_one_image_only() -> None:
    lockstep = started()
    lockstep.image_published(IMAGE_US, 0.1)
    lockstep.setpoint_received(10**9, has_viewers=True)
    assert lockstep.may_advance(0.2, has_viewers=True)
    lockstep.image_published(2 * IMAGE_US, 0.3)
    assert not lockstep.may_advance(0.4, has_viewers=True)


def test_time_runs_free_when_the_viewer_has_left_until_one_answers_again() -> None:
    lockstep = started()
    lockstep.image_published(IMAGE_US, 0.1)
    assert lockstep.may_advance(0.2, has_viewers=False)
    assert lockstep.is_free
    lockstep.image_published(2 * IMAGE_US, 0.3)
    assert lockstep.may_advance(0.4, has_viewers=True)  # somebody looks, but has not answered
    lockstep.setpoint_received(2 * IMAGE_US, has_viewers=True)
    assert not lockstep.is_free
    lockstep.image_published(3 * IMAGE_US, 0.5)
    assert not lockstep.may_advance(0.6, has_viewers=True)


def test_patience_ends_once_with_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    lockstep = started()
    with caplog.at_level(logging.WARNING):
        lockstep.image_published(IMAGE_US, 0.0)
        assert not lockstep.may_advance(PATIENCE_S, has_viewers=True)
        assert lockstep.may_advance(PATIENCE_S + 0.01, has_viewers=True)
        assert lockstep.is_free
        lockstep.setpoint_received(IMAGE_US, has_viewers=True)
        lockstep.image_published(2 * IMAGE_US, 20.0)
        assert lockstep.may_advance(31.0, has_viewers=True)
    assert len(caplog.records) == 1
    assert "0.052" in caplog.text
