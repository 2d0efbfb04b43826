"""The body against mechanics: weight, torques, lag, drag, contact."""

import math
from collections.abc import Iterator

import pybullet
import pytest

from sitl.frames import GRAVITY_M_S2, quaternion_from_euler, rotate, rotate_inverse
from sitl.records.motion import VehicleState
from sitl.world.airframe import load_airframe
from sitl.world.body import QuadrotorBody

X500 = load_airframe("x500")
HOVER = X500.hover_thrust
ZERO = (0.0, 0.0, 0.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)
TICK_S = 0.004


class Bench:
    """A body, alone in the air."""

    def __init__(self) -> None:
        self.client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0.0, 0.0, -GRAVITY_M_S2, physicsClientId=self.client)
        pybullet.setTimeStep(TICK_S, physicsClientId=self.client)
        self.body = QuadrotorBody(self.client, X500, position_ned=(0.0, 0.0, -10.0))

    def put(
        self,
        q: tuple[float, float, float, float] = LEVEL,
        velocity: tuple[float, float, float] = ZERO,
        thrust: float = HOVER,
        position: tuple[float, float, float] = (0.0, 0.0, -10.0),
    ) -> None:
        self.body.reset(position_ned=position, velocity_ned=velocity, q_ned_frd=q, thrust=thrust)

    def run(self, motors: tuple[float, float, float, float], ticks: int = 1) -> VehicleState:
        for _ in range(ticks):
            self.body.apply(motors, TICK_S)
            pybullet.stepSimulation(physicsClientId=self.client)
        return self.body.state(0)


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    pybullet.disconnect(bench.client)


def test_hover_thrust_carries_the_weight(bench: Bench) -> None:
    bench.put()
    state = bench.run((HOVER,) * 4, ticks=250)
    assert math.hypot(*state.velocity_ned) < 1e-6
    assert state.specific_force_frd == pytest.approx((0.0, 0.0, -GRAVITY_M_S2))


def test_without_thrust_it_falls_freely(bench: Bench) -> None:
    bench.put(thrust=0.0)
    state = bench.run((0.0,) * 4, ticks=100)
    assert state.velocity_ned == pytest.approx((0.0, 0.0, 0.4 * GRAVITY_M_S2), abs=1e-9)
    assert state.specific_force_frd == pytest.approx(ZERO, abs=1e-9)


@pytest.mark.parametrize("euler", [(0.3, 0.2, 1.0), (-0.4, 0.1, -2.5), (1.2, -0.7, 3.0)])
def test_thrust_pushes_along_the_body_axis_in_any_attitude(
    bench: Bench, euler: tuple[float, float, float]
) -> None:
    q = quaternion_from_euler(*euler)
    bench.put(q=q)
    state = bench.run((HOVER,) * 4)
    thrust_ned = rotate(q, (0.0, 0.0, -GRAVITY_M_S2))
    expected = (thrust_ned[0], thrust_ned[1], thrust_ned[2] + GRAVITY_M_S2)
    assert tuple(v / TICK_S for v in state.velocity_ned) == pytest.approx(expected, abs=1e-6)
    overlap = sum(a * b for a, b in zip(state.q_ned_frd, q, strict=True))
    assert abs(overlap) == pytest.approx(1.0)  # either sign is the same attitude


@pytest.mark.parametrize(
    ("axis", "signs"),
    [
        (0, (-1, 1, 1, -1)),  # roll to the right: the left rotors push
        (1, (1, -1, 1, -1)),  # nose up: the front rotors push
        (2, (1, 1, -1, -1)),  # nose to the right: the counterclockwise rotors push
    ],
)
@pytest.mark.parametrize("euler", [ZERO, (0.5, -0.3, 2.0)])
def test_torques_turn_the_body_the_right_way_in_any_attitude(
    bench: Bench, axis: int, signs: tuple[int, int, int, int], euler: tuple[float, float, float]
) -> None:
    bench.put(q=quaternion_from_euler(*euler))
    first, second, third, fourth = (HOVER + 0.05 * sign for sign in signs)
    motors = (first, second, third, fourth)
    rates = bench.run(motors, ticks=10).rates_frd
    assert rates[axis] > 0.005
    assert max(abs(rates[other]) for other in range(3) if other != axis) < 0.01 * rates[axis]


def test_roll_acceleration_is_torque_over_inertia(bench: Bench) -> None:
    bench.put()
    motors = (HOVER - 0.05, HOVER + 0.05, HOVER + 0.05, HOVER - 0.05)
    bench.run(motors, ticks=120)  # the rotors are there
    before = bench.body.state(0).rates_frd[0]
    after = bench.run(motors).rates_frd[0]
    torque = 4 * 0.05 * X500.rotors.max_thrust_n * 0.174 - 0.025 * before
    assert (after - before) / TICK_S == pytest.approx(torque / 0.0217, rel=0.01)


def test_rotors_follow_with_a_lag_each_way(bench: Bench) -> None:
    bench.put(thrust=0.25)
    bench.run((1.0,) * 4, ticks=3)  # 12 ms
    up = bench.body.rotor_speeds_rad_s[0]
    assert up == pytest.approx(1000.0 - 500.0 * math.exp(-0.012 / 0.05))
    bench.put(thrust=1.0)
    bench.run((0.25,) * 4, ticks=3)
    down = bench.body.rotor_speeds_rad_s[0]
    assert down == pytest.approx(500.0 + 500.0 * math.exp(-0.012 / 0.05))


def test_thrust_is_linear_in_the_command(bench: Bench) -> None:
    for thrust in (0.2, 0.5, 0.9):
        bench.put(thrust=thrust)
        state = bench.run((thrust,) * 4)
        lift = 4 * thrust * X500.rotors.max_thrust_n / X500.mass_kg
        assert state.specific_force_frd[2] == pytest.approx(-lift)


def test_commands_beyond_the_range_are_cut(bench: Bench) -> None:
    bench.put(thrust=1.0)
    bench.run((7.0, -3.0, 1.0, 0.0), ticks=500)
    assert bench.body.rotor_speeds_rad_s == pytest.approx((1000.0, 0.0, 1000.0, 0.0), abs=0.1)


def test_drag_is_that_of_the_rotors(bench: Bench) -> None:
    bench.put(velocity=(3.0, -2.0, 0.0))
    state = bench.run((HOVER,) * 4)
    omega = math.sqrt(HOVER) * 1000.0
    per_speed = 4 * 8.06428e-5 * omega / X500.mass_kg
    x, y, _ = state.specific_force_frd
    assert (x, y) == pytest.approx((-3.0 * per_speed, 2.0 * per_speed), rel=1e-3)


def test_wind_pushes_like_motion_through_still_air(bench: Bench) -> None:
    bench.put(velocity=(3.0, -2.0, 0.5))
    moving = bench.run((HOVER,) * 4).specific_force_frd
    bench.put()
    bench.body.wind_ned = (-3.0, 2.0, -0.5)
    blown = bench.run((HOVER,) * 4).specific_force_frd
    assert blown == pytest.approx(moving, abs=1e-9)


def test_turning_is_damped(bench: Bench) -> None:
    bench.put()
    bench.run((HOVER + 0.1, HOVER + 0.1, HOVER - 0.1, HOVER - 0.1), ticks=100)
    before = bench.body.state(0).rates_frd[2]
    after = bench.run((HOVER,) * 4, ticks=250).rates_frd[2]
    assert 0.0 < after < 0.5 * before


def test_stands_on_the_ground_and_feels_its_weight(bench: Bench) -> None:
    ground = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=bench.client)
    pybullet.createMultiBody(baseCollisionShapeIndex=ground, physicsClientId=bench.client)
    bench.put(position=(0.0, 0.0, -0.3), thrust=0.0)
    state = bench.run((0.0,) * 4, ticks=500)
    assert state.position_ned == pytest.approx((0.0, 0.0, -0.05), abs=1e-3)
    assert state.specific_force_frd == pytest.approx((0.0, 0.0, -GRAVITY_M_S2), abs=1e-2)


def test_reset_forgets_everything(bench: Bench) -> None:
    bench.put()
    bench.run((0.9, 0.1, 0.4, 0.7), ticks=100)
    q = quaternion_from_euler(0.0, 0.0, 1.0)
    bench.put(q=q, velocity=(1.0, 2.0, 0.0), position=(3.0, 4.0, -5.0))
    state = bench.body.state(7)
    assert state.time_us == 7
    assert state.position_ned == pytest.approx((3.0, 4.0, -5.0))
    assert state.velocity_ned == pytest.approx((1.0, 2.0, 0.0))
    assert state.rates_frd == pytest.approx(ZERO)
    first = bench.run((0.5, 0.6, 0.7, 0.5), ticks=50)
    bench.put(q=q, velocity=(1.0, 2.0, 0.0), position=(3.0, 4.0, -5.0))
    assert bench.run((0.5, 0.6, 0.7, 0.5), ticks=50) == first


def test_rates_are_in_the_body_frame(bench: Bench) -> None:
    bench.put(q=quaternion_from_euler(math.pi / 2, 0.0, 0.0))
    state = bench.run((HOVER + 0.1, HOVER + 0.1, HOVER - 0.1, HOVER - 0.1), ticks=20)
    assert state.rates_frd[2] > 0.01
    turning_ned = rotate(state.q_ned_frd, state.rates_frd)
    assert abs(turning_ned[1]) > 0.01  # body z lies along -y here
    assert rotate_inverse(state.q_ned_frd, turning_ned) == pytest.approx(state.rates_frd)


def test_two_bodies_in_one_client_do_not_disturb_each_other(bench: Bench) -> None:
    other = QuadrotorBody(bench.client, X500, position_ned=(5.0, 0.0, -10.0), yaw_rad=1.0)
    before = other.state(0)
    bench.put()
    bench.body.apply((1.0,) * 4, TICK_S)
    assert other.state(0) == before
    assert other.body_id != bench.body.body_id
