"""The day of a flight in Python reaches the vehicle as it reads it."""

from flightstack.launch.flight import vehicle_options
from sitl.process.options.command_line import parse


def test_conditions_are_read_as_they_were_meant() -> None:
    day = {
        "wind.mean_ned_m_s": (1.0, 0.0, -0.5),
        "camera.latency_s": 0.1,
        "light.fog_visibility_m": 20,
    }
    options = parse(vehicle_options(3, day), {})
    assert options.seed == 3
    assert options.conditions.wind.mean_ned_m_s == (1.0, 0.0, -0.5)
    assert options.conditions.camera.latency_s == 0.1
    assert options.conditions.light.fog_visibility_m == 20.0
