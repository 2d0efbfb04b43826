from pathlib import Path

import pytest

from sitl.errors import UsageError
from sitl.process.options.command_line import Options, parse


def given(*argv: str, **environment: str) -> Options:
    return parse(argv, environment)


def test_defaults_are_px4s() -> None:
    options = given()
    assert options.gcs_ports == (18570, 14550)
    assert options.api_ports == (14580, 14540)
    assert options.camera_port == 8090
    assert options.home == (47.397742, 8.545594, 489.4)
    assert (options.noise_m, options.laps, options.speed_factor) == ((1.0, 2.0), 1, 1.0)
    assert (options.system, options.lockstep, options.verbosity) == (1, False, 0)


def test_the_vehicle_is_ready_as_late_as_px4_except_in_lockstep() -> None:
    assert given().ready_after_s == 4.0  # 3.6 to 4.8 s were seen
    assert given("--lockstep").ready_after_s == 1.0
    assert given("--lockstep", "--ready-after=3").ready_after_s == 3.0
    for wrong in ("0.9", "nan", "inf", "soon"):
        with pytest.raises(UsageError, match="ready-after"):
            given(f"--ready-after={wrong}")


def test_an_instance_moves_its_ports_but_not_the_ground_stations() -> None:
    options = given("--instance", "3")
    assert options.gcs_ports == (18573, 14550)
    assert options.api_ports == (14583, 14543)
    assert (options.camera_port, options.system) == (8093, 4)
    assert given("--instance=12").api_ports == (14592, 14549)


def test_ports_can_be_chosen() -> None:
    options = given("--gcs-link=0:6000", "--api-link=7000:7001", "--camera-port=0")
    assert options.gcs_ports == (0, 6000)
    assert options.api_ports == (7000, 7001)
    assert options.camera_port == 0


def test_further_links_can_be_named() -> None:
    assert (given().udp, given().tcp) == ((), ())
    options = given("--udp=127.0.0.1:14551", "--udp=host:14552", "--tcp=5760", "--tcp=0.0.0.0:5761")
    assert options.udp == (("127.0.0.1", 14551), ("host", 14552))
    assert options.tcp == (("127.0.0.1", 5760), ("0.0.0.0", 5761))  # noqa: S104  asked for
    assert given("--tcp=:0").tcp == (("127.0.0.1", 0),)


def test_video_goes_where_it_is_asked_to() -> None:
    assert given().video is None
    assert given("--video=udp://127.0.0.1:5600").video == ("127.0.0.1", 5600)


def test_the_command_line_goes_before_the_environment() -> None:
    assert given(PX4_SIM_SPEED_FACTOR="4").speed_factor == 4.0
    assert given("--speed-factor=0", PX4_SIM_SPEED_FACTOR="4").speed_factor == 0.0
    assert given(PX4_HOME_LAT="10", PX4_HOME_ALT="-3").home == (10.0, 8.545594, -3.0)
    assert given("--home=1,2,3", PX4_HOME_LAT="10").home == (1.0, 2.0, 3.0)


def test_parameters_come_from_the_environment() -> None:
    options = given(PX4_PARAM_COM_OF_LOSS_T="2.5", PATH="/bin")
    assert options.parameters == {"COM_OF_LOSS_T": "2.5"}


def test_everything_can_be_said() -> None:
    options = given(
        *("--seed=5", "--track-seed=6", "--noise=0,0.5", "--direction=ccw", "--laps=4"),
        *("--lockstep", "--gui", "--log=flight.tlog", "-v"),
    )
    assert (options.seed, options.track_seed, options.noise_m) == (5, 6, (0.0, 0.5))
    assert (options.direction, options.laps, options.log) == ("ccw", 4, Path("flight.tlog"))
    assert (options.lockstep, options.gui, options.verbosity) == (True, True, 1)


@pytest.mark.parametrize(
    ("argument", "fragments"),
    [
        ("--noise=one,two", ["--noise", "1.0,2.0", "one,two"]),
        ("--noise=1", ["--noise", "2 numbers"]),
        ("--noise=-1,2", ["--noise", "negative"]),
        ("--noise=nan,1", ["--noise", "nan"]),
        ("--seed=-1", ["--seed", "-1"]),
        ("--laps=0", ["--laps", "1 to 1000"]),
        ("--speed-factor=-2", ["--speed-factor", "0.01 to 1000"]),
        ("--speed-factor=inf", ["--speed-factor", "inf"]),
        ("--instance=250", ["--instance", "249"]),
        ("--home=91,0,0", ["--home", "latitude"]),
        ("--home=47,8", ["--home", "3 numbers"]),
        ("--direction=up", ["--direction", "cw"]),
        ("--camera-port=70000", ["--camera-port", "65535"]),
        ("--gcs-link=14550", ["--gcs-link", "LOCAL:REMOTE"]),
        ("--udp=14550", ["--udp", "HOST:PORT"]),
        ("--udp=host:0", ["--udp", "1 to 65535"]),
        ("--tcp=host:many", ["--tcp", "65535"]),
        ("--video=127.0.0.1:5600", ["--video", "udp://"]),
        ("--nonsense", ["--nonsense"]),
    ],
)
def test_what_cannot_be_is_named_with_its_remedy(argument: str, fragments: list[str]) -> None:
    with pytest.raises(UsageError) as refusal:
        given(argument)
    text = str(refusal.value)
    assert "\n" not in text
    assert all(fragment in text for fragment in fragments)


@pytest.mark.parametrize(
    ("name", "value"), [("PX4_SIM_SPEED_FACTOR", "fast"), ("PX4_HOME_LAT", "north")]
)
def test_a_wrong_environment_is_named(name: str, value: str) -> None:
    with pytest.raises(UsageError, match=value):
        given(**{name: value})
