"""The modes' encodings, as a running PX4 1.17 showed them."""

import pytest

from sitl.records.modes import BASE_ARMED, Mode, mode_of

OBSERVED = [
    (Mode.MANUAL, 0x00010000, 81),
    (Mode.ALTCTL, 0x00020000, 81),
    (Mode.POSCTL, 0x00030000, 81),
    (Mode.ACRO, 0x00050000, 65),
    (Mode.STABILIZED, 0x00070000, 81),
    (Mode.OFFBOARD, 0x00060000, 1),
    (Mode.TAKEOFF, 0x02040000, 29),
    (Mode.HOLD, 0x03040000, 29),
    (Mode.MISSION, 0x04040000, 29),
    (Mode.RTL, 0x05040000, 29),
    (Mode.LAND, 0x06040000, 29),
    (Mode.FOLLOW, 0x08040000, 17),
    (Mode.PRECLAND, 0x09040000, 29),
]


@pytest.mark.parametrize(("mode", "custom_mode", "base_mode"), OBSERVED)
def test_encoding(mode: Mode, custom_mode: int, base_mode: int) -> None:
    assert mode.custom_mode == custom_mode
    assert mode.base_mode == base_mode


def test_armed_flag() -> None:
    assert Mode.HOLD.base_mode | BASE_ARMED == 157
    assert Mode.POSCTL.base_mode | BASE_ARMED == 209


@pytest.mark.parametrize("mode", list(Mode))
def test_numbers_lead_back_to_the_mode(mode: Mode) -> None:
    assert mode_of(mode.value.main, mode.value.sub) is mode


@pytest.mark.parametrize(("main", "sub"), [(99, 0), (0, 0), (4, 0), (4, 7), (4, 99)])
def test_unknown_numbers_name_no_mode(main: int, sub: int) -> None:
    assert mode_of(main, sub) is None


def test_sub_mode_counts_in_auto_only() -> None:
    assert mode_of(6, 3) is Mode.OFFBOARD
