import pytest

from sitl.records import VehicleState
from sitl.sensors.estimator import Estimator


def state(time_us: int) -> VehicleState:
    return VehicleState(
        time_us=time_us,
        position_ned=(1.0, 2.0, -3.0),
        velocity_ned=(0.1, 0.2, 0.3),
        q_ned_frd=(1.0, 0.0, 0.0, 0.0),
        rates_frd=(0.01, 0.02, 0.03),
        specific_force_frd=(0.0, 0.0, -9.8),
    )


@pytest.mark.parametrize(
    ("time_us", "attitude", "altitude", "position"),
    [
        (0, False, False, False),
        (196_000, False, False, False),
        (200_000, True, False, False),
        (600_000, True, True, False),
        (996_000, True, True, False),
        (1_000_000, True, True, True),
    ],
)
def test_becomes_valid_step_by_step(time_us, attitude, altitude, position):
    estimate = Estimator().update(state(time_us))
    assert estimate.attitude_valid is attitude
    assert estimate.altitude_valid is altitude
    assert estimate.position_valid is position


def test_a_start_in_the_air_is_aligned():
    estimate = Estimator(aligned=True).update(state(0))
    assert estimate.attitude_valid
    assert estimate.position_valid
    assert estimate.altitude_valid


def test_gives_the_state():
    assert Estimator().update(state(4000))[:6] == state(4000)
