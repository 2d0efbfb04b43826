"""What may be asked of a vehicle that another simulator moves."""

import pytest

from sitl.errors import UsageError
from sitl.process.options.command_line import Options, parse


def external(*given: str) -> Options:
    return parse(["--autopilot=external", *given], {})


def test_it_listens_where_px4s_sih_tells_its_pose() -> None:
    options = external("--instance=2").external
    assert options is not None
    assert (options.kind, options.address) == ("udpin", ("127.0.0.1", 19412))


def test_it_may_go_out_to_another_host() -> None:
    options = external("--connect=udpout:10.0.0.7:5000").external
    assert options is not None
    assert (options.kind, options.address) == ("udpout", ("10.0.0.7", 5000))


@pytest.mark.parametrize(
    "given",
    [
        ["--lockstep"],
        ["--speed-factor=2"],
        ["--perfect-estimate"],
        ["--condition=wind.gust_std_m_s=1"],
        ["--condition=estimate.rotor_noise_share=1"],
        ["--connect=tcp:127.0.0.1:1"],
        ["--hil-port=4560"],
    ],
)
def test_what_its_own_simulator_does_is_refused_by_name(given: list[str]) -> None:
    option = given[0].partition("=")[0]
    with pytest.raises(UsageError, match=option):
        external(*given)


def test_a_link_of_poses_needs_such_a_vehicle() -> None:
    with pytest.raises(UsageError, match="only with --autopilot external"):
        parse(["--connect=udpin:1"], {})
