"""A model that flies by a belief, as two real processes, with an estimate that M0 cannot fly by."""

from pathlib import Path

import pytest

from flightstack.launch.flight import fly_request
from flightstack.launch.request import FlightRequest

pytestmark = pytest.mark.flight


def test_a_course_is_flown_by_an_estimate_that_the_rotors_shake(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    request = FlightRequest(
        track_seed=3,
        noise="0.5,1.0",
        model="strong/b0",
        speed_factor=0.0,
        vehicle_options=("-q", "--condition=estimate.rotor_noise_share=1.0"),
        companion_options=("-q", "--json"),
    )
    result = fly_request(request)
    assert (result.outcome, result.gates_passed) == ("completed", 8)
