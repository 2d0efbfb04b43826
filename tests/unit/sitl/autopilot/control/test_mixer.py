import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from sitl.autopilot.control.mixer import Mixer
from sitl.world.airframe import load_airframe

X500 = load_airframe("x500")
MIXER = Mixer(X500.rotors.positions_frd_m, X500.rotors.yaw_moments_m)
TORQUES = st.floats(-1.0, 1.0)
LEVER = 0.174  # m
YAW_ARM = 0.016  # m


def torques(motors: tuple[float, float, float, float]) -> tuple[float, float, float]:
    """Roll, pitch, yaw that the rotors give, on the mixer's own scale."""
    rows = zip(motors, X500.rotors.positions_frd_m, X500.rotors.yaw_moments_m, strict=True)
    roll = pitch = yaw = 0.0
    for thrust, (x, y), moment in rows:
        roll -= y * thrust
        pitch += x * thrust
        yaw += moment * thrust
    half_root = 2.0**0.5 / 2.0
    return (
        roll / (4.0 * LEVER * half_root),
        pitch / (4.0 * LEVER * half_root),
        yaw / (4.0 * YAW_ARM),
    )


def test_thrust_alone_goes_to_all_rotors_alike() -> None:
    motors, _ = MIXER.mix((0.0, 0.0, 0.0), 0.4)
    assert motors == pytest.approx((0.4,) * 4)


def test_unit_torques_have_the_scale_of_px4() -> None:
    motors, _ = MIXER.mix((0.1, 0.0, 0.0), 0.5)
    assert motors == pytest.approx(
        (0.5 - 0.0707, 0.5 + 0.0707, 0.5 + 0.0707, 0.5 - 0.0707), abs=1e-4
    )
    motors, _ = MIXER.mix((0.0, 0.0, 0.1), 0.5)
    assert motors == pytest.approx((0.6, 0.6, 0.4, 0.4))


@given(roll=TORQUES, pitch=TORQUES, yaw=TORQUES, thrust=st.floats(0.0, 1.0))
@example(roll=0.0, pitch=1.0, yaw=0.0, thrust=5.7e-220)  # rounding leaves less than no room
def test_rotors_stay_within_their_range(
    roll: float, pitch: float, yaw: float, thrust: float
) -> None:
    motors, _ = MIXER.mix((roll, pitch, yaw), thrust)
    assert all(0.0 <= motor <= 1.0 for motor in motors)


@given(roll=TORQUES, pitch=TORQUES, yaw=TORQUES, thrust=st.floats(0.0, 1.0))
def test_torque_is_never_reversed_nor_thrust_raised(
    roll: float, pitch: float, yaw: float, thrust: float
) -> None:
    motors, _ = MIXER.mix((roll, pitch, yaw), thrust)
    for given_torque, wanted in zip(torques(motors), (roll, pitch, yaw), strict=True):
        assert given_torque * wanted >= -1e-9
        assert abs(given_torque) <= abs(wanted) + 1e-9
    assert sum(motors) / 4.0 <= thrust + 1e-9


@given(
    roll=st.floats(-0.15, 0.15),
    pitch=st.floats(-0.15, 0.15),
    yaw=st.floats(-0.15, 0.15),
    thrust=st.floats(0.4, 0.6),
)
def test_what_fits_is_given_exactly(roll: float, pitch: float, yaw: float, thrust: float) -> None:
    motors, saturated = MIXER.mix((roll, pitch, yaw), thrust)
    assert torques(motors) == pytest.approx((roll, pitch, yaw), abs=1e-12)
    assert sum(motors) / 4.0 == pytest.approx(thrust)
    assert saturated == (0.0, 0.0, 0.0)


def test_yaw_gives_way_before_roll_and_pitch() -> None:
    motors, saturated = MIXER.mix((0.3, -0.2, 1.0), 0.5)
    roll, pitch, yaw = torques(motors)
    assert (roll, pitch) == pytest.approx((0.3, -0.2))
    assert 0.0 < yaw < 1.0
    assert saturated == (0.0, 0.0, 1.0)


def test_full_thrust_gives_way_to_roll() -> None:
    motors, _ = MIXER.mix((0.4, 0.0, 0.0), 1.0)
    assert torques(motors)[0] == pytest.approx(0.4)


def test_no_thrust_means_no_torque() -> None:
    motors, saturated = MIXER.mix((0.4, -0.3, 0.2), 0.0)
    assert motors == pytest.approx((0.0,) * 4)
    assert saturated == (1.0, -1.0, 1.0)
