"""The state estimate that the autopilot flies by: for now the truth, once it has settled.

The flags become true a fixed time after boot, as they do while an EKF aligns itself.
"""

from sitl.records import Estimate, VehicleState

ATTITUDE_VALID_US = 200_000  # assumption: tilt alignment of a still vehicle
ALTITUDE_VALID_US = 600_000  # assumption: barometer
POSITION_VALID_US = 1_000_000  # assumption: GPS; a real EKF takes some 8 s


class Estimator:
    """Turns the true state into what the autopilot believes."""

    def __init__(self, *, aligned: bool = False) -> None:
        self._aligned = aligned

    def update(self, state: VehicleState) -> Estimate:
        """Estimate the state at `state.time_us`; a vehicle that starts in the air is aligned."""
        time_us = state.time_us
        aligned = self._aligned
        return Estimate(
            *state,
            aligned or time_us >= ATTITUDE_VALID_US,
            aligned or time_us >= POSITION_VALID_US,
            aligned or time_us >= ALTITUDE_VALID_US,
        )
