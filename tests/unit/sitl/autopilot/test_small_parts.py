"""Take-off stages, land detector, hover thrust, return height, setpoint stream."""

import math
from typing import Any

import pytest

from sitl.autopilot.control.hover_thrust import HoverThrust, HoverThrustParameters
from sitl.autopilot.flight_modes.land_detector import LandDetector, LandDetectorParameters
from sitl.autopilot.flight_modes.offboard import LATENCY_US, OffboardParameters, OffboardStream
from sitl.autopilot.flight_modes.return_home import ReturnHome, ReturnParameters, ReturnPhase
from sitl.autopilot.flight_modes.takeoff import Takeoff, TakeoffParameters, TakeoffStage
from sitl.autopilot.parameters import Parameters
from sitl.records.sensing import Estimate
from sitl.records.vehicle import OffboardSetpoint

NAN = math.nan
ZERO = (0.0, 0.0, 0.0)


@pytest.fixture
def parameters() -> Parameters:
    return Parameters()


def estimate(time_us: int, velocity: tuple[float, float, float] = ZERO) -> Estimate:
    return Estimate(
        time_us=time_us,
        position_ned=ZERO,
        velocity_ned=velocity,
        q_ned_frd=(1.0, 0.0, 0.0, 0.0),
        rates_frd=ZERO,
        specific_force_frd=ZERO,
        attitude_valid=True,
        position_valid=True,
        altitude_valid=True,
    )


def test_take_off_spools_up_waits_ramps_and_flies(parameters: Parameters) -> None:
    takeoff = Takeoff(TakeoffParameters.resolve(parameters.values))

    def stage_at(time_s: float, *, climb: bool) -> TakeoffStage:
        return takeoff.update(round(time_s * 1e6), armed=True, landed=True, wants_climb=climb)

    assert stage_at(0.0, climb=True) is TakeoffStage.SPOOL_UP
    assert stage_at(0.99, climb=True) is TakeoffStage.SPOOL_UP
    assert stage_at(1.0, climb=False) is TakeoffStage.READY
    assert stage_at(5.0, climb=False) is TakeoffStage.READY
    assert stage_at(6.0, climb=True) is TakeoffStage.RAMP_UP
    # No thrust at all.
    assert takeoff.speed_limit(6_000_000, 3.0) == pytest.approx(-9.80665 / 4.0)
    half_way = takeoff.speed_limit(7_500_000, 3.0)
    assert half_way == pytest.approx((3.0 - 9.80665 / 4.0) / 2.0)
    takeoff.update(9_000_000, armed=True, landed=False, wants_climb=True)
    assert takeoff.state.stage is TakeoffStage.FLIGHT
    assert takeoff.speed_limit(9_000_000, 3.0) == 3.0
    assert (
        takeoff.update(9_100_000, armed=True, landed=True, wants_climb=True) is TakeoffStage.READY
    )
    disarmed = takeoff.update(9_200_000, armed=False, landed=True, wants_climb=True)
    assert disarmed is TakeoffStage.DISARMED


def test_landing_is_believed_in_steps_and_flight_at_once(parameters: Parameters) -> None:
    detector = LandDetector(LandDetectorParameters.resolve(parameters.values))
    detector.start_airborne()
    times = [round(4000 * tick) for tick in range(1, 300)]
    landed_at = next(
        time
        for time in times
        if detector.update(estimate(time), armed=True, descending=True, thrust=0.1)
    )
    assert landed_at == pytest.approx(1_000_000, abs=20_000)  # LNDMC_TRIG_TIME
    assert not detector.update(estimate(1_300_000), armed=True, descending=False, thrust=0.5)


@pytest.mark.parametrize(
    ("velocity", "thrust", "descending"),
    [
        ((0.0, 0.0, 0.5), 0.1, True),  # sinking
        ((2.0, 0.0, 0.0), 0.1, True),  # sliding
        (ZERO, 0.5, True),  # carried
        (ZERO, 0.1, False),  # nobody wants to go down
    ],
)
def test_flying_is_not_mistaken_for_standing(
    parameters: Parameters, velocity: tuple[float, float, float], thrust: float, *, descending: bool
) -> None:
    detector = LandDetector(LandDetectorParameters.resolve(parameters.values))
    detector.start_airborne()
    for tick in range(1, 1000):
        now = estimate(4000 * tick, velocity)
        assert not detector.update(now, armed=True, descending=descending, thrust=thrust)


@pytest.mark.parametrize("true_hover", [0.35, 0.5, 0.7])
def test_hover_thrust_is_learnt(parameters: Parameters, true_hover: float) -> None:
    settings = HoverThrustParameters.resolve(parameters.values)
    hover = HoverThrust(settings)
    for tick in range(2500):
        thrust = 0.5 + 0.1 * math.sin(tick / 50.0)
        hover.learn(thrust, 9.80665 * (thrust / true_hover - 1.0), settings)
    assert hover.value == pytest.approx(true_hover, rel=0.01)


def test_hover_thrust_is_not_learnt_when_told_not_to(parameters: Parameters) -> None:
    parameters.set("MPC_USE_HTE", 0)
    settings = HoverThrustParameters.resolve(parameters.values)
    hover = HoverThrust(settings)
    hover.learn(0.5, 3.0, settings)
    assert hover.value == 0.5
    hover.know(0.3, settings)
    assert hover.value == 0.5


@pytest.mark.parametrize(
    ("north_m", "height_m", "expected_m"),
    [
        (1.0, 6.0, 6.0),  # above home: as it is
        (5.0, 2.0, 5.0),  # within the cone: 45 deg
        (3.0, 2.0, 4.0),  # within the cone, but no lower than twice the acceptance radius
        (5.0, 12.0, 12.0),  # never a descent
        (50.0, 6.0, 30.0),  # far away: RTL_RETURN_ALT
        (50.0, 40.0, 40.0),
    ],
)
def test_return_height(
    parameters: Parameters, north_m: float, height_m: float, expected_m: float
) -> None:
    resolved = ReturnParameters.resolve(parameters.values)
    way = ReturnHome.start((north_m, 0.0, -height_m), ZERO, NAN, resolved)
    assert way.height_m == pytest.approx(expected_m)


def test_return_waits_above_home_as_long_as_it_is_told(parameters: Parameters) -> None:
    parameters.set("RTL_LAND_DELAY", 5.0)
    resolved = ReturnParameters.resolve(parameters.values)
    way, phases = ReturnHome.start((0.0, 0.0, -5.0), ZERO, NAN, resolved), []
    for second in range(10):
        way = way.advance(round(1e6 * second), (0.0, 0.0, -5.0), 0.0, resolved)
        phases.append(way.phase)
    assert phases[:3] == [ReturnPhase.RETURN, ReturnPhase.DESCEND, ReturnPhase.WAIT]
    assert phases[6:8] == [ReturnPhase.WAIT, ReturnPhase.LAND]
    assert way.advance(10**9, (0.0, 0.0, -5.0), 0.0, resolved) is way


def test_return_from_near_home_waits_for_the_heading_at_home(parameters: Parameters) -> None:
    resolved = ReturnParameters.resolve(parameters.values)
    way, phases = ReturnHome.start((3.0, 0.0, -6.0), ZERO, math.pi, resolved), []
    for angle in (-90.0, -100.0, -167.0, -169.0, -179.0):
        way = way.advance(0, (0.0, 0.0, -6.0), math.radians(angle), resolved)
        phases.append(way.phase)
    assert phases == [*[ReturnPhase.RETURN] * 3, ReturnPhase.DESCEND, ReturnPhase.WAIT]
    assert way.yaw_rad == math.pi


def test_a_bad_setpoint_leaves_the_last_good_one_for_200_ms(parameters: Parameters) -> None:
    stream = OffboardStream(OffboardParameters.resolve(parameters.values))
    stream.receive(OffboardSetpoint(time_us=0, velocity_ned=(1.0, 0.0, 0.0), yaw_rate_rad_s=0.0))
    stream.receive(OffboardSetpoint(time_us=50_000, velocity_ned=(NAN, 0.0, 0.0)))
    assert stream.setpoint(200_000, 0.0).velocity_ned == (1.0, 0.0, 0.0)
    assert stream.setpoint(250_000, 0.0).velocity_ned == ZERO
    assert stream.is_alive(1_049_999)
    assert not stream.is_alive(1_050_000)


@pytest.mark.parametrize(
    "setpoint",
    [
        {"velocity_ned": (1.0, NAN, 0.0)},
        {"velocity_ned": (1.0, 0.0, NAN)},
        {"position_ned": (1.0, NAN, 0.0), "velocity_ned": (NAN, 1.0, NAN)},
        {},
    ],
)
def test_setpoints_that_leave_an_axis_open_stop_the_vehicle(
    parameters: Parameters, setpoint: dict[Any, Any] | dict[str, tuple[float, float, float]]
) -> None:
    stream = OffboardStream(OffboardParameters.resolve(parameters.values))
    stream.receive(OffboardSetpoint(time_us=0, **setpoint))
    assert stream.setpoint(300_000, 0.0).velocity_ned == ZERO


def test_velocity_with_a_height_is_complete(parameters: Parameters) -> None:
    stream = OffboardStream(OffboardParameters.resolve(parameters.values))
    stream.receive(
        OffboardSetpoint(
            time_us=0, position_ned=(NAN, NAN, -5.0), velocity_ned=(1.0, 0.0, NAN), yaw_rad=0.0
        )
    )
    assert stream.setpoint(300_000, 0.0).position_ned[2] == -5.0


def test_heading_is_held_from_the_moment_nobody_asks_for_one(parameters: Parameters) -> None:
    stream = OffboardStream(OffboardParameters.resolve(parameters.values))
    stream.receive(OffboardSetpoint(time_us=0, velocity_ned=ZERO))
    assert stream.setpoint(0, 0.4).yaw_rad == 0.4
    assert stream.setpoint(4000, 0.9).yaw_rad == 0.4
    stream.receive(OffboardSetpoint(time_us=8000, velocity_ned=ZERO, yaw_rate_rad_s=0.1))
    assert stream.setpoint(8000, 0.9).yaw_rad == 0.4  # it takes a tick to act
    assert math.isnan(stream.setpoint(12000, 0.9).yaw_rad)


def test_climbing_setpoints_ask_for_a_take_off(parameters: Parameters) -> None:
    stream = OffboardStream(OffboardParameters.resolve(parameters.values))
    assert not stream.wants_climb(0, 0.0)
    stream.receive(OffboardSetpoint(time_us=0, velocity_ned=(0.0, 0.0, -0.5), yaw_rad=0.0))
    assert stream.wants_climb(LATENCY_US, 0.0)
    stream.receive(OffboardSetpoint(time_us=0, position_ned=(0.0, 0.0, -2.0), yaw_rad=0.0))
    assert stream.wants_climb(LATENCY_US, 0.0)
    assert not stream.wants_climb(LATENCY_US, -3.0)
