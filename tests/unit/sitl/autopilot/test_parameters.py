import struct

import pytest

from sitl.autopilot.parameters import Parameters, ParameterType
from sitl.errors import UsageError
from tests.observed.parameters import DEFAULTS, NEEDED


@pytest.fixture
def parameters() -> Parameters:
    return Parameters()


@pytest.mark.parametrize("name", sorted(NEEDED))
def test_has_what_ground_stations_ask_for(parameters: Parameters, name: str) -> None:
    assert name in parameters


@pytest.mark.parametrize("name", sorted(name for name in NEEDED if name.endswith("_ID")))
def test_calibration_looks_done(parameters: Parameters, name: str) -> None:
    assert parameters.get(name) != 0


@pytest.mark.parametrize(("name", "value"), list(DEFAULTS.items()))
def test_defaults_are_those_of_px4(parameters: Parameters, name: str, value: float) -> None:
    assert parameters.get(name) == pytest.approx(value, rel=1e-7)
    kind = ParameterType.INT32 if isinstance(value, int) else ParameterType.REAL32
    assert parameters.type_of(name) is kind


def test_every_default_lies_in_its_range(parameters: Parameters) -> None:
    for name in parameters.names():
        spec = parameters.specification(name)
        assert spec.minimum <= spec.default <= spec.maximum, name


def test_names_fit_the_wire_and_are_sorted(parameters: Parameters) -> None:
    names = parameters.names()
    assert names == sorted(names)
    assert all(len(name) <= 16 for name in names)


def test_decimals_are_stored_in_single_precision(parameters: Parameters) -> None:
    parameters.set("MPC_XY_P", 0.3)
    assert parameters.get("MPC_XY_P") == struct.unpack("<f", struct.pack("<f", 0.3))[0]


def test_limits_themselves_are_allowed(parameters: Parameters) -> None:
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
def test_what_is_not_allowed_is_refused_and_changes_nothing(
    parameters: Parameters, name: str, value: float, complaint: str
) -> None:
    before = parameters.values
    with pytest.raises(UsageError, match=f"^parameter {name}: {complaint}$"):
        parameters.set(name, value)
    assert parameters.values is before


def test_text_as_from_the_environment(parameters: Parameters) -> None:
    parameters.set_from_text("COM_OBL_RC_ACT", "5")
    assert parameters.get("COM_OBL_RC_ACT") == 5
    assert isinstance(parameters.get("COM_OBL_RC_ACT"), int)
    with pytest.raises(UsageError, match="must be a number, got 'five'"):
        parameters.set_from_text("COM_OBL_RC_ACT", "five")


def test_a_change_makes_another_table_and_leaves_the_old_one(parameters: Parameters) -> None:
    before = parameters.values
    parameters.set("MPC_XY_P", 0.95)
    assert parameters.values is before
    parameters.set("MPC_XY_P", 1.0)
    assert before["MPC_XY_P"] == pytest.approx(0.95)
    assert parameters.values["MPC_XY_P"] == 1.0
    assert {**parameters.values, "MPC_XY_P": before["MPC_XY_P"]} == before


def test_an_airframe_may_change_defaults() -> None:
    parameters = Parameters({"MPC_THR_HOVER": 0.6, "SYS_AUTOSTART": 4001})
    assert parameters.get("MPC_THR_HOVER") == pytest.approx(0.6)
    assert parameters.get("SYS_AUTOSTART") == 4001
