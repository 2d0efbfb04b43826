"""The simulated vehicle with the emulated autopilot, in process: what training and tests fly."""

import math

from sitl.emulated_controller import EmulatedController, make_estimator
from sitl.flown_vehicle import ESTIMATE_STREAM, FlownVehicle, SimulationConfig, chance
from sitl.frames import quaternion_from_euler
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.sensors.imu import Imu
from sitl.world.airframe import Airframe


class Simulation(FlownVehicle[EmulatedController]):
    """The vehicle in its world; its autopilot and course are public, for whoever talks to them."""

    def __init__(self, config: SimulationConfig) -> None:
        """Build the world at time 0, the vehicle on the ground at the spawn point.

        Raises:
            UsageError: the track's noise or the airframe cannot be.

        """
        super().__init__(config, lambda airframe, imu: _make_controller(config, airframe, imu))
        self.autopilot = self.controller.autopilot
        self.parameters = self.controller.parameters

    @property
    def estimate(self) -> Estimate:
        """What the autopilot believes."""
        return self.controller.estimate

    def start_airborne(self, position_ned: Vector3, yaw_rad: float, speed_m_s: float = 0.0) -> None:
        """Put the vehicle into the air: armed, in OFFBOARD, flying straight ahead."""
        velocity = (speed_m_s * math.cos(yaw_rad), speed_m_s * math.sin(yaw_rad), 0.0)
        self._put(position_ned, velocity, quaternion_from_euler(0.0, 0.0, yaw_rad))
        self.controller.align()
        self._sense()
        self.autopilot.start_airborne()


def _make_controller(config: SimulationConfig, airframe: Airframe, imu: Imu) -> EmulatedController:
    estimator = make_estimator(
        chance(config, ESTIMATE_STREAM),
        imu,
        is_perfect=config.perfect_estimate,
        rotor_noise_share=config.conditions.estimate.rotor_noise_share,
        settled_s=config.settled_s,
    )
    return EmulatedController(airframe, estimator, home=config.home)
