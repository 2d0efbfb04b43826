import struct

import pytest

from sitl.autopilot.parameters import Parameters, ParameterType
from sitl.errors import UsageError

# What QGroundControl complains about when it is missing.
GROUND_STATION = [
    *("SYS_AUTOSTART", "SYS_AUTOCONFIG", "SYS_PARAM_VER", "MAV_SYS_ID", "TRIG_MODE"),
    *("CAL_GYRO0_ID", "CAL_ACC0_ID", "CAL_MAG0_ID", "CAL_MAG1_ID", "CAL_MAG2_ID"),
    *("CAL_MAG0_ROT", "CAL_MAG1_ROT", "CAL_MAG2_ROT", "UAVCAN_ENABLE"),
    *("RC_MAP_ROLL", "RC_MAP_PITCH", "RC_MAP_YAW", "RC_MAP_THROTTLE"),
    *("RC_MAP_FLAPS", "RC_MAP_AUX1", "RC_MAP_AUX2"),
    *("COM_FLTMODE1", "COM_FLTMODE2", "COM_FLTMODE3"),
    *("COM_FLTMODE4", "COM_FLTMODE5", "COM_FLTMODE6"),
    *("COM_RC_IN_MODE", "COM_RC_LOSS_T", "COM_LOW_BAT_ACT", "NAV_DLL_ACT", "NAV_RCL_ACT"),
    *("BAT1_SOURCE", "BAT_LOW_THR", "BAT_CRIT_THR", "BAT_EMERGEN_THR"),
    *("RTL_LAND_DELAY", "RTL_DESCEND_ALT", "RTL_RETURN_ALT"),
    *("SENS_BOARD_ROT", "SENS_BOARD_X_OFF", "SENS_BOARD_Y_OFF", "SENS_BOARD_Z_OFF"),
    "SENS_DPRES_OFF",
]

# A sample of what was read from a running PX4 1.17.
OBSERVED = {
    "COM_OF_LOSS_T": 1.0,
    "COM_OBL_RC_ACT": 0,
    "COM_DISARM_LAND": 2.0,
    "COM_DISARM_PRFLT": 10.0,
    "COM_DL_LOSS_T": 10,
    "MIS_TAKEOFF_ALT": 2.5,
    "MPC_XY_P": 0.95,
    "MPC_XY_VEL_P_ACC": 1.8,
    "MPC_Z_VEL_I_ACC": 2.0,
    "MPC_THR_MIN": 0.12,
    "MC_ROLL_P": 4.0,
    "MC_YAWRATE_P": 0.2,
    "RTL_RETURN_ALT": 30.0,
    "LNDMC_Z_VEL_MAX": 0.25,
    "SDLOG_MODE": 1,
}


@pytest.fixture
def parameters() -> Parameters:
    return Parameters()


@pytest.mark.parametrize("name", GROUND_STATION)
def test_has_what_ground_stations_ask_for(parameters, name):
    assert name in parameters


@pytest.mark.parametrize("name", [name for name in GROUND_STATION if name.endswith("_ID")])
def test_calibration_looks_done(parameters, name):
    assert parameters.get(name) != 0


@pytest.mark.parametrize(("name", "value"), list(OBSERVED.items()))
def test_defaults_are_those_of_px4(parameters, name, value):
    assert parameters.get(name) == pytest.approx(value, rel=1e-7)
    kind = ParameterType.INT32 if isinstance(value, int) else ParameterType.REAL32
    assert parameters.type_of(name) is kind


def test_every_default_lies_in_its_range(parameters):
    for name in parameters.names():
        spec = parameters.specification(name)
        assert spec.minimum <= spec.default <= spec.maximum, name


def test_names_fit_the_wire_and_are_sorted(parameters):
    names = parameters.names()
    assert names == sorted(names)
    assert all(len(name) <= 16 for name in names)


def test_decimals_are_stored_in_single_precision(parameters):
    parameters.set("MPC_XY_P", 0.3)
    assert parameters.get("MPC_XY_P") == struct.unpack("<f", struct.pack("<f", 0.3))[0]


def test_limits_themselves_are_allowed(parameters):
    parameters.set("MPC_THR_HOVER", 0.8)
    parameters.set("MPC_THR_HOVER", 0.1)
    assert parameters.get("MPC_THR_HOVER") == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("name", "value", "complaint"),
    [
        ("MPC_THR_HOVER", 0.81, "must be 0.1 to 0.8 norm, got 0.81"),
        ("COM_OBL_RC_ACT", 8, "must be 0 to 7, got 8"),
        ("COM_OBL_RC_ACT", 1.5, "must be a whole number, got 1.5"),
        ("MPC_XY_P", float("nan"), "must be finite, got nan"),
        ("MPC_XY_P", float("inf"), "must be finite, got inf"),
        ("NO_SUCH_NAME", 1.0, "unknown"),
    ],
)
def test_what_is_not_allowed_is_refused_and_changes_nothing(parameters, name, value, complaint):
    before = {name: parameters.get(name) for name in parameters.names()}
    with pytest.raises(UsageError, match=f"^parameter {name}: {complaint}$"):
        parameters.set(name, value)
    assert {name: parameters.get(name) for name in parameters.names()} == before
    assert parameters.version == 0


def test_text_as_from_the_environment(parameters):
    parameters.set_from_text("COM_OBL_RC_ACT", "5")
    assert parameters.get("COM_OBL_RC_ACT") == 5
    assert isinstance(parameters.get("COM_OBL_RC_ACT"), int)
    with pytest.raises(UsageError, match="must be a number, got 'five'"):
        parameters.set_from_text("COM_OBL_RC_ACT", "five")


def test_version_counts_changes_only(parameters):
    parameters.set("MPC_XY_P", 0.95)
    assert parameters.version == 0
    parameters.set("MPC_XY_P", 1.0)
    assert parameters.version == 1


def test_an_airframe_may_change_defaults():
    parameters = Parameters({"MPC_THR_HOVER": 0.6, "SYS_AUTOSTART": 4001})
    assert parameters.get("MPC_THR_HOVER") == pytest.approx(0.6)
    assert parameters.get("SYS_AUTOSTART") == 4001
