from importlib.resources import files

import pytest

from sitl.autopilot.parameters import Parameters
from sitl.errors import UsageError
from sitl.world.airframe import load_airframe, parse_airframe

X500 = (files("sitl.world") / "airframes" / "x500.toml").read_text()


def test_x500_is_the_published_one() -> None:
    x500 = load_airframe("x500")
    assert x500.mass_kg == 2.064
    assert x500.inertia_kg_m2 == (0.0217, 0.0217, 0.040)
    assert x500.rotors.max_thrust_n == pytest.approx(8.549)
    assert x500.rotors.yaw_moments_m == (0.016, 0.016, -0.016, -0.016)
    assert x500.hover_thrust == pytest.approx(0.592, abs=0.001)


def test_its_parameters_are_ones_that_the_autopilot_has() -> None:
    parameters = Parameters(load_airframe("x500").parameters)
    assert parameters.get("SYS_AUTOSTART") == 4001
    assert parameters.get("MPC_THR_HOVER") == pytest.approx(0.6)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("mass_kg = 2.064", "", "mass_kg: missing"),
        ("mass_kg = 2.064", "mass_kg = 0", "mass_kg: must be a number above 0, got 0"),
        ("mass_kg = 2.064", "mass_kg = -1.0", "mass_kg: must be a number above 0, got -1.0"),
        ("mass_kg = 2.064", 'mass_kg = "heavy"', "mass_kg: must be a number above 0, got 'heavy'"),
        ("mass_kg = 2.064", "mass_kg = 2.064\ncolour = 1", "colour: unknown key"),
        ("0.0217, 0.0217, 0.040", "0.0217, 0.0217", "inertia_kg_m2: must be 3 numbers"),
        ("0.0217, 0.0217, 0.040", "0.0217, 0.0, 0.040", "inertia_kg_m2: must be a number above 0"),
        ("[1, 1, -1, -1]", "[1, 1, 1, -1]", "rotors.directions: must be two 1 and two -1"),
        ("[0.174, 0.174], ", "", "rotors.positions_frd_m: must be 4 lists"),
        ("[drag]", "[drug]", "drug: unknown table"),
        (
            "max_speed_rad_s = 1000.0",
            "max_speed_rad_s = 500.0",
            "too weak, hover takes 2.37 of its thrust",
        ),
        ("[rotors]", "[rotors", "not TOML"),
    ],
)
def test_faults_are_named_in_one_line(old: str, new: str, complaint: str) -> None:
    assert old in X500
    with pytest.raises(UsageError) as error:
        parse_airframe("mine", X500.replace(old, new, 1))
    assert str(error.value).startswith(f"airframe mine: {complaint}")
    assert "\n" not in str(error.value)


def test_an_unknown_airframe_is_answered_with_the_known_ones() -> None:
    with pytest.raises(UsageError, match=r"^airframe 'x900': unknown; known are: x500$"):
        load_airframe("x900")
