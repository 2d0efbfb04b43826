from sitl.mavlink.links.ground_station import LOST, REGAINED, GroundStationWatch

SECOND_US = 1_000_000


def test_nothing_is_lost_that_was_never_heard() -> None:
    assert GroundStationWatch().check(3600 * SECOND_US, 10.0) is None


def test_a_silent_ground_station_is_lost_once_and_found_again() -> None:
    watch = GroundStationWatch()
    assert watch.heard(0) is None
    assert watch.check(10 * SECOND_US, 10.0) is None
    assert watch.check(10 * SECOND_US + 4000, 10.0) == LOST
    assert watch.check(20 * SECOND_US, 10.0) is None
    assert watch.heard(21 * SECOND_US) == REGAINED
    assert watch.heard(22 * SECOND_US) is None
    assert watch.check(33 * SECOND_US, 10.0) == LOST
