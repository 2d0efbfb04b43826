"""Who else steers the vehicle shows in what it follows, and in a second heartbeat of ours."""

from dataclasses import replace

import pytest

from flightstack.companion.guards.one_pilot import REMEMBERED, OnePilot
from flightstack.companion.mission.records import MissionPhase
from flightstack.mavlink.offboard import Velocities
from flightstack.mavlink.telemetry import Telemetry
from flightstack.px4_modes import Px4Mode

FLYING = MissionPhase.FLYING
OFFBOARD = Telemetry(custom_mode=Px4Mode.OFFBOARD, armed=True)
OURS: Velocities = (3.0, 4.0, 0.5, 0.2)
IMAGE_US, BEAT_IMAGES = 50_000, 20


class Watched:
    """Images of a flight in which the vehicle follows what the test says."""

    def __init__(self) -> None:
        self.watch = OnePilot()
        self.image = 0
        self.beat_us = 0

    def fly(
        self,
        images: int,
        target: Velocities = OURS,
        mode: int = Px4Mode.OFFBOARD,
        sent: Velocities = OURS,
    ) -> bool:
        found = False
        for _ in range(images):
            self.image += 1
            if self.image % BEAT_IMAGES == 0:
                self.beat_us = self.image * IMAGE_US
            seen = replace(
                OFFBOARD,
                custom_mode=mode,
                heartbeat_us=self.beat_us,
                target_ned=target[:3],
                target_yaw_rate=target[3],
                target_us=self.image * IMAGE_US,
            )
            found = self.watch.has_other(FLYING, seen, {})
            self.watch.note_setpoint(sent)
        return found


def test_our_own_velocities_are_nobody_elses_however_the_vehicle_heads() -> None:
    assert not Watched().fly(200, target=(-5.0, 0.0, 0.5, 0.2))


@pytest.mark.parametrize(
    "target",
    [
        (0.0, 0.0, 0.5, 0.2),
        (9.0, 0.0, 0.5, 0.2),
        (3.0, 4.0, -0.5, 0.2),
        (3.0, 4.0, 0.5, -0.4),
    ],
)
def test_velocities_that_we_have_not_sent_are_somebody_elses(target: Velocities) -> None:
    watched = Watched()
    assert not watched.fly(100)
    assert watched.fly(3 * BEAT_IMAGES, target=target)


def test_a_vehicle_that_limits_itself_is_not_somebody_else() -> None:
    watched = Watched()
    assert not watched.fly(200, target=(6.0, 8.0, 1.5, 0.2), sent=(6.0, 8.0, 3.0, 0.2))
    assert not watched.fly(100, target=(6.0, 6.0, 1.5, 0.2), sent=(6.0, 8.0, 3.0, 0.2))


def test_a_mode_that_has_just_been_left_is_not_somebody_else() -> None:
    watched = Watched()
    assert not watched.fly(100)
    assert not watched.fly(BEAT_IMAGES - 1, target=(0.0, 0.0, 0.0, 0.0))
    assert not watched.fly(100, target=(0.0, 0.0, 0.0, 0.0), mode=Px4Mode.LOITER)


def test_nothing_is_judged_before_enough_was_sent() -> None:
    assert not Watched().fly(REMEMBERED - 1, target=(0.0, 0.0, 0.0, 0.0))


def test_numbers_that_are_none_say_nothing() -> None:
    assert not Watched().fly(200, target=(float("nan"), 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("phase", "found"),
    [(MissionPhase.WAITING, True), (MissionPhase.ARMING, True), (MissionPhase.LANDING, False)],
)
def test_a_second_heartbeat_of_ours_counts_before_the_vehicle_is_lifted(
    phase: MissionPhase,
    found: bool,  # noqa: FBT001
) -> None:
    assert OnePilot().has_other(phase, Telemetry(), {191: 18}) is found
    assert not OnePilot().has_other(phase, Telemetry(), {192: 18})
