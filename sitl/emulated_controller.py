"""The emulated flight controller: an estimator and an autopilot, as one."""

import numpy as np

from sitl.autopilot.autopilot import Autopilot
from sitl.autopilot.parameters import Parameters
from sitl.records.failures import Failure
from sitl.records.motion import MotorThrusts, Vector3, VehicleState
from sitl.records.sensing import NO_ESTIMATE, Estimate, Readings
from sitl.sensors.battery import Pack
from sitl.sensors.estimate.estimator import SETTLED_S, Estimator, PerfectEstimator
from sitl.sensors.imu import Imu
from sitl.world.airframe import Airframe


class EmulatedController:
    """Estimates at the end of a tick, flies by the estimate in the next."""

    def __init__(
        self, airframe: Airframe, estimator: Estimator | PerfectEstimator, *, home: Vector3
    ) -> None:
        self.parameters = Parameters(airframe.parameters)
        self.autopilot = Autopilot(
            self.parameters,
            rotor_positions_frd_m=airframe.rotors.positions_frd_m,
            rotor_yaw_moments_m=airframe.rotors.yaw_moments_m,
            hover_thrust=airframe.hover_thrust,
            home=home,
        )
        self.estimate: Estimate = NO_ESTIMATE
        self._estimator = estimator
        self._values = self.parameters.values
        self._pack = Pack.resolve(self._values)

    def sense(self, state: VehicleState, readings: Readings) -> None:
        """Estimate the state at the end of a tick."""
        self.estimate = self._estimator.update(state, readings)

    def drive(self) -> MotorThrusts:
        """Advance the autopilot by one tick."""
        return self.autopilot.step(self.estimate)

    def drain_failures(self) -> list[Failure]:
        """Hand over the failures that the autopilot was asked for."""
        return self.autopilot.drain_failures()

    @property
    def armed(self) -> bool:
        """Whether the rotors may turn."""
        return self.autopilot.armed

    @property
    def pack(self) -> Pack:
        """The battery by the present parameters."""
        if self.parameters.values is not self._values:
            self._values = self.parameters.values
            self._pack = Pack.resolve(self._values)
        return self._pack

    def align(self) -> None:
        """Have the estimator aligned at once: the vehicle is put into the air."""
        self._estimator.align()


def make_estimator(
    rng: np.random.Generator,
    imu: Imu,
    *,
    is_perfect: bool = False,
    rotor_noise_share: float = 0.0,
    settled_s: float = SETTLED_S,
) -> Estimator | PerfectEstimator:
    """Make what estimates: one that errs, and has learnt this inertial unit's biases, or none."""
    if is_perfect:
        return PerfectEstimator(settled_s=settled_s)
    return Estimator(
        rng,
        imu.gyro_bias_frd,
        imu.accelerometer_bias_frd,
        rotor_noise_share=rotor_noise_share,
        settled_s=settled_s,
    )
