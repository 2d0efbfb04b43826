"""On no rung of the ladder is the camera taken for one that lies, through fog and dark neither."""

import math

import numpy as np
import pytest

from flightstack.camera.watch import MIN_STRUCTURE_LEVELS, ImageWatch, structure_levels
from flightstack.evaluation.trials.rungs import known_rungs, load_rung
from flightstack.records import Image
from sitl import CAMERA_RATE_HZ, OffboardSetpoint, Simulation, SimulationConfig
from sitl.records.conditions import read_conditions

TICKS = 4 * 250  # seconds of vehicle time
CLIMB, FORWARD = (0.0, 0.0, -1.0), (2.0, 0.0, 0.0)


@pytest.mark.parametrize("name", known_rungs())
def test_nothing_is_said_of_a_camera_on_a_rung(name: str) -> None:
    rung, condition = load_rung(name)
    changes = [option.removeprefix("--condition=") for option in condition.vehicle_options]
    config = SimulationConfig(
        noise_m=rung.noise_m, direction=rung.direction, conditions=read_conditions(None, changes)
    )
    simulation, watch = Simulation(config), ImageWatch(CAMERA_RATE_HZ)
    simulation.start_airborne((0.0, 0.0, -1.0), 0.0)
    flattest = math.inf
    for tick in range(TICKS):
        if simulation.image_due():
            taken = simulation.render()
            image = Image(stamp_us=taken.time_us, sequence=taken.sequence, rgb=taken.rgb)
            assert watch.look(image, math.hypot(*simulation.state.velocity_ned)) is None
            flattest = min(flattest, structure_levels(np.asarray(taken.rgb)))
            setpoint = OffboardSetpoint(
                time_us=simulation.time_us,
                velocity_ned=CLIMB if tick < TICKS // 4 else FORWARD,
                yaw_rate_rad_s=0.3,
            )
            simulation.autopilot.offboard_setpoint(setpoint)
        simulation.step()
    simulation.close()
    assert flattest > 2 * MIN_STRUCTURE_LEVELS
