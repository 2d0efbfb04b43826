"""MAVSDK, written by others, asks a vehicle what it is: info, parameters, telemetry, camera."""

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from mavsdk import System
from mavsdk.plugins.action import Action
from mavsdk.plugins.camera import Camera, CameraError, CameraResult
from mavsdk.plugins.info import Info
from mavsdk.plugins.info.info import Version
from mavsdk.plugins.param import Param, ParamError, ParamResult
from mavsdk.plugins.telemetry import FlightMode, LandedState, Telemetry

from sitl.autopilot.parameters import Parameters, ParameterType
from tests.flight.clients.mavsdk_vehicle import Latest, found_vehicle

pytestmark = pytest.mark.flight
CAMERA = 100
RATES_HZ = {  # as PX4 sends them unprompted, and what they are changed to; by the vehicle's stamps
    "attitude_euler": (100.0, 20.0),
    "imu": (50.0, 25.0),
    "odometry": (30.0, 10.0),
}
SAMPLES = 20


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> Iterator[System]:
    with found_vehicle(tmp_path_factory.mktemp("vehicle")) as found:
        yield found


@pytest.fixture(scope="module")
def streams(system: System) -> Latest:
    """Listen from the start: MAVSDK asks for a camera's streams some seconds after it was found."""
    return Latest(Camera(system).subscribe_video_stream_info)


@pytest.fixture(scope="module")
def info(system: System) -> Info:
    """MAVSDK asks for it once a second, and does not wait longer for the answer."""
    return Info(system)


@pytest.mark.usefixtures("streams", "info")
def test_health_and_what_it_says_on_the_ground(system: System) -> None:
    telemetry = Telemetry(system)
    Latest(telemetry.subscribe_health_all_ok).until(bool, "healthy", timeout_s=20.0)
    health = telemetry.health()
    assert all(
        (
            health.is_gyrometer_calibration_ok,
            health.is_accelerometer_calibration_ok,
            health.is_magnetometer_calibration_ok,
            health.is_local_position_ok,
            health.is_global_position_ok,
            health.is_home_position_ok,
            health.is_armable,
        )
    )
    modes, states = telemetry.subscribe_flight_mode, telemetry.subscribe_landed_state
    assert Latest(modes).next() == FlightMode.HOLD
    assert Latest(states).next() == LandedState.ON_GROUND
    home = Latest(telemetry.subscribe_home).next()
    assert (home.latitude_deg, home.longitude_deg) == pytest.approx((47.3977, 8.5456), abs=1e-4)
    battery = Latest(telemetry.subscribe_battery).next()
    assert (battery.voltage_v, battery.remaining_percent) == pytest.approx((16.2, 100.0))


def test_who_it_is(info: Info) -> None:
    version = info.get_version()
    assert (version.flight_sw_major, version.flight_sw_minor) >= (1, 15)
    assert version.flight_sw_version_type == Version.FlightSoftwareVersionType.RELEASE
    assert int(info.get_identification().hardware_uid, 16) > 0


@pytest.mark.parametrize("name", RATES_HZ)
def test_telemetry_comes_as_often_as_it_is_asked_for(system: System, name: str) -> None:
    telemetry = Telemetry(system)
    samples = Latest(getattr(telemetry, f"subscribe_{name}"))
    unprompted_hz, asked_hz = RATES_HZ[name]
    assert rate_of(samples) == pytest.approx(unprompted_hz, rel=0.03)
    getattr(telemetry, f"set_rate_{name}")(asked_hz)
    assert rate_of(samples) == pytest.approx(asked_hz, rel=0.03)


def rate_of(samples: Latest) -> float:
    samples.drain()
    taken = [samples.pop() for _ in range(SAMPLES)]
    stamps_us = [getattr(s, "timestamp_us", None) or s.time_usec for s in taken]
    assert all(later > earlier for earlier, later in itertools.pairwise(stamps_us))
    return float((SAMPLES - 1) * 1e6 / (stamps_us[-1] - stamps_us[0]))


def test_parameters(system: System) -> None:
    param, action, known = Param(system), Action(system), Parameters()
    listed = param.get_all_params()
    for kind, found in (
        (ParameterType.INT32, listed.int_params),
        (ParameterType.REAL32, listed.float_params),
    ):
        assert {p.name for p in found} == {n for n in known.names() if known.type_of(n) is kind}
    assert param.get_param_int("MAV_SYS_ID") == system.get_system_id()
    param.set_param_float("MPC_XY_CRUISE", 4.5)
    param.set_param_int("COM_OBL_RC_ACT", 4)
    assert param.get_param_float("MPC_XY_CRUISE") == 4.5
    assert param.get_param_int("COM_OBL_RC_ACT") == 4
    action.set_takeoff_altitude(3.5)
    assert param.get_param_float("MIS_TAKEOFF_ALT") == action.get_takeoff_altitude() == 3.5


@pytest.mark.parametrize(
    ("ask", "refusal"),
    [
        (lambda param: param.get_param_int("NO_SUCH"), ParamResult.TIMEOUT),  # PX4 is silent
        (lambda param: param.get_param_int("MPC_XY_CRUISE"), ParamResult.WRONG_TYPE),
    ],
)
def test_parameters_that_there_are_not(
    system: System, ask: Callable[[Param], Any], refusal: ParamResult
) -> None:
    with pytest.raises(ParamError) as failure:
        ask(Param(system))
    assert str(failure.value).startswith(refusal.name)


def test_arming_and_killing(system: System) -> None:
    action, armed = Action(system), Latest(Telemetry(system).subscribe_armed)
    for end in (action.disarm, action.kill):
        action.arm()
        armed.until(bool, "armed", timeout_s=5.0)
        end()
        armed.until(lambda value: not value, end.__name__, timeout_s=5.0)
    assert not armed.next()


def test_the_camera(system: System, streams: Latest) -> None:
    camera = Camera(system)
    listed = Latest(camera.subscribe_camera_list)
    (found,) = listed.until(lambda value: value.cameras, "camera", timeout_s=10.0).cameras
    assert (found.component_id, found.model_name) == (CAMERA, "sitl camera")
    assert (found.horizontal_resolution_px, found.vertical_resolution_px) == (64, 64)
    with pytest.raises(CameraError) as refusal:
        camera.take_photo(CAMERA)
    assert str(refusal.value).startswith(CameraResult.ACTION_UNSUPPORTED.name)
    update = streams.until(lambda stream: stream.component_id == CAMERA, "stream", timeout_s=30.0)
    settings = update.video_stream_info.settings
    assert settings.uri.startswith("http://127.0.0.1:")
    assert (settings.frame_rate_hz, settings.horizontal_fov_deg) == (20.0, 90.0)
