"""The state estimate that the autopilot flies by: the truth, late, with slow errors and flags.

A model of how a Kalman filter behaves, not a filter: its errors are drawn (see `drift`), and what
a failed sensor does to a filter is done to them. The flags become true a fixed time after boot, as
they do while a filter aligns itself, and false once an aid has been missing for too long.
"""

import math

import numpy as np

from sitl.clock import SECOND_US
from sitl.frames import rotate
from sitl.records.motion import Vector3, VehicleState
from sitl.records.sensing import Estimate, Readings
from sitl.sensors.estimate.drift import Drift, accuracy_m
from sitl.sensors.estimate.gyro_filter import GyroFilter
from sitl.sensors.estimate.shaken import ZERO, ShakenDrift
from sitl.sensors.noise import normals

ATTITUDE_VALID_US = 200_000  # assumption: tilt alignment of a still vehicle
ALTITUDE_VALID_US = 600_000  # assumption: barometer
POSITION_VALID_US = 3_000_000  # at most: a running PX4 v1.17.0 had a home at 2.4 to 3.2 s
SETTLED_S = 1.0  # when a vehicle may take off; a running PX4 v1.17.0 said so after 4 s
NO_AID_US = 5_000_000  # PX4 EKF2_NOAID_TOUT: dead reckoning counts as valid for this long


class PerfectEstimator:
    """Gives the truth at once; only the flags are those of a real one."""

    def __init__(self, *, aligned: bool = False, settled_s: float = SETTLED_S) -> None:
        self._validity = _Validity(aligned=aligned, settled_s=settled_s)

    def align(self) -> None:
        """Be aligned at once, as a vehicle is that starts in the air."""
        self._validity.aligned = True

    def update(self, state: VehicleState, readings: Readings | None = None) -> Estimate:
        """Estimate the state at `state.time_us`."""
        flags = self._validity.update(state.time_us, readings)
        settled = self._validity.is_settled(state.time_us)
        if readings is None:
            return Estimate(*state, *flags, settled=settled)
        return Estimate(*state, *flags, readings.health, readings.battery, settled=settled)


class Estimator:
    """Turns the true state and the sensors' readings into what the autopilot believes.

    It is one tick late, smooths the body rates, and has learnt the inertial unit's biases.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        gyro_bias_frd: Vector3,
        accelerometer_bias_frd: Vector3,
        *,
        rotor_noise_share: float = 0.0,
        settled_s: float = SETTLED_S,
    ) -> None:
        """Begin on the ground; a share above 0 lets that much of the rotors' noise in."""
        self._gyro_bias, self._accelerometer_bias = gyro_bias_frd, accelerometer_bias_frd
        self._shaken: ShakenDrift | None = None
        if rotor_noise_share > 0.0:
            self._shaken = ShakenDrift(normals(rng), share=rotor_noise_share)
        self._drift = self._shaken or Drift(normals(rng))
        self._gyro_filter = GyroFilter()
        self._validity = _Validity(aligned=False, settled_s=settled_s)
        self._located = self._is_inertial = True
        self._previous: tuple[VehicleState, Readings] | None = None

    def align(self) -> None:
        """Be aligned at once, and forget the last tick: the vehicle has been put elsewhere."""
        self._validity.aligned = True
        self._previous = None
        self._gyro_filter.restart()

    def update(self, state: VehicleState, readings: Readings) -> Estimate:
        """Estimate the state at `state.time_us`."""
        drift, sensors = self._drift, readings.health
        flags = self._validity.update(state.time_us, readings)
        if sensors.gps and not self._located:
            drift.restart_xy()
        self._located = flags[1] or state.time_us < self._validity.position_us
        seen, sensed = self._previous or (state, readings)
        self._previous = (state, readings)
        shaken = self._shaken
        if shaken is not None:
            self._shake(shaken, seen, sensed)
        drift.advance(
            xy_aided=sensors.gps,
            z_aided=sensors.gps or sensors.barometer,
            heading_aided=sensors.magnetometer,
        )
        return Estimate(
            state.time_us,
            _add(seen.position_ned, drift.position_ned),
            _add(seen.velocity_ned, drift.velocity_ned),
            drift.turn(seen.q_ned_frd),
            _subtract(self._gyro_filter.update(sensed.rates_frd), self._gyro_bias),
            _subtract(sensed.specific_force_frd, self._accelerometer_bias),
            *flags,
            sensors,
            readings.battery,
            drift.aided_m if sensors.gps else self._validity.accuracy_m(state.time_us),
            self._validity.is_settled(state.time_us),
            math.nan if shaken is None else seen.velocity_ned[2] + shaken.z_deriv_m_s,
        )

    def _shake(self, drift: ShakenDrift, seen: VehicleState, sensed: Readings) -> None:
        """Let what the inertial unit misreads in, as long as it is believed."""
        health = sensed.health
        is_inertial = health.gyro and health.accelerometer
        if is_inertial and not self._is_inertial:
            drift.restart(xy_aided=health.gps, z_aided=health.gps or health.barometer)
        self._is_inertial = is_inertial
        drift.feel(*(self._misread(seen, sensed) if is_inertial else (ZERO, ZERO)))

    def _misread(self, seen: VehicleState, sensed: Readings) -> tuple[Vector3, Vector3]:
        """Give the noise of specific force and body rates, turned into NED."""
        force = _subtract(sensed.specific_force_frd, seen.specific_force_frd)
        rates = _subtract(sensed.rates_frd, seen.rates_frd)
        return (
            rotate(seen.q_ned_frd, _subtract(force, self._accelerometer_bias)),
            rotate(seen.q_ned_frd, _subtract(rates, self._gyro_bias)),
        )


class _Validity:
    """Says what the estimate is good for."""

    def __init__(self, *, aligned: bool, settled_s: float) -> None:
        self.aligned = aligned
        self._settled_us = round(settled_s * SECOND_US)
        self.position_us = min(POSITION_VALID_US, self._settled_us)
        self._gps_us = self._height_us = 0  # when each aid was last there

    def update(self, time_us: int, readings: Readings | None) -> tuple[bool, bool, bool]:
        """Give the validity of attitude, horizontal position and altitude."""
        inertial = True
        if readings is None:
            self._gps_us = self._height_us = time_us
        else:
            sensors = readings.health
            inertial = sensors.gyro and sensors.accelerometer
            if sensors.gps:
                self._gps_us = self._height_us = time_us
            elif sensors.barometer:
                self._height_us = time_us
        aligned = self.aligned
        return (
            inertial and (aligned or time_us >= ATTITUDE_VALID_US),
            inertial
            and (aligned or time_us >= self.position_us)
            and time_us - self._gps_us < NO_AID_US,
            inertial
            and (aligned or time_us >= ALTITUDE_VALID_US)
            and time_us - self._height_us < NO_AID_US,
        )

    def is_settled(self, time_us: int) -> bool:
        """Say whether it is long enough after boot."""
        return self.aligned or time_us >= self._settled_us

    def accuracy_m(self, time_us: int) -> tuple[float, float]:
        """Give the spread of the position's errors, horizontal and vertical."""
        return accuracy_m(time_us - self._gps_us, time_us - self._height_us)


def _add(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _subtract(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
