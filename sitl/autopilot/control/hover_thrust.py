"""Learn in flight what thrust the vehicle hovers at: a Kalman filter with one state.

The model is that of PX4's hover thrust estimator: upward acceleration = g (thrust / hover - 1).
"""

from sitl.autopilot.parameters import Parameters
from sitl.frames import GRAVITY_M_S2

INITIAL_VARIANCE = 0.1**2  # PX4 HTE_HT_ERR_INIT
PROCESS_NOISE = 0.0036**2  # 1/s, PX4 HTE_HT_NOISE
MEASUREMENT_VARIANCE = 1.0  # (m/s2)^2, assumption: PX4 adapts it in flight
LIMITS = (0.1, 0.8)  # as MPC_THR_HOVER


class HoverThrust:
    """Keeps the estimate and its variance."""

    def __init__(self, parameters: Parameters) -> None:
        self.load(parameters)
        self.reset()

    def load(self, parameters: Parameters) -> None:
        """Take the initial value from the parameters."""
        self._learns = bool(parameters["MPC_USE_HTE"])
        self._initial = parameters["MPC_THR_HOVER"]

    def reset(self, value: float | None = None) -> None:
        """Begin anew, or know the value already."""
        self.value = self._initial if value is None or not self._learns else value
        self._variance = INITIAL_VARIANCE if value is None else PROCESS_NOISE

    def update(self, thrust: float, acceleration_m_s2: float, dt_s: float) -> None:
        """Take in the upward thrust (0..1) and the upward acceleration that it gave."""
        if not self._learns:
            return
        self._variance += PROCESS_NOISE * dt_s
        hover = self.value
        innovation = acceleration_m_s2 - GRAVITY_M_S2 * (thrust / hover - 1.0)
        slope = -GRAVITY_M_S2 * thrust / (hover * hover)
        gain = self._variance * slope / (slope * slope * self._variance + MEASUREMENT_VARIANCE)
        self._variance *= 1.0 - gain * slope
        self.value = min(max(hover + gain * innovation, LIMITS[0]), LIMITS[1])
