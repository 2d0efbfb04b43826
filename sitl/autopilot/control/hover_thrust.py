"""Learn in flight what thrust the vehicle hovers at: a Kalman filter with one state.

The model is that of PX4's hover thrust estimator: upward acceleration = g (thrust / hover - 1).
"""

from typing import NamedTuple, Self

from sitl.autopilot.parameters import ParameterValues
from sitl.clock import TICK_S
from sitl.frames import GRAVITY_M_S2

INITIAL_VARIANCE = 0.1**2  # PX4 HTE_HT_ERR_INIT
PROCESS_NOISE = 0.0036**2  # 1/s, PX4 HTE_HT_NOISE
MEASUREMENT_VARIANCE = 1.0  # (m/s2)^2, assumption: PX4 adapts it in flight
LIMITS = (0.1, 0.8)  # as MPC_THR_HOVER


class HoverThrustParameters(NamedTuple):
    """Where the estimate begins, and whether it moves at all."""

    learns: bool  # MPC_USE_HTE
    initial: float  # MPC_THR_HOVER

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values."""
        return cls(learns=bool(values["MPC_USE_HTE"]), initial=values["MPC_THR_HOVER"])


class HoverThrust:
    """Keeps the estimate and its variance.

    Plain attributes: a frozen record would cost each tick 0.2 us of its 24.
    """

    __slots__ = ("_variance", "value")

    def __init__(self, parameters: HoverThrustParameters) -> None:
        self.value = parameters.initial  # 0..1
        self._variance = INITIAL_VARIANCE

    def reset(self, parameters: HoverThrustParameters) -> None:
        """Begin anew."""
        self.value, self._variance = parameters.initial, INITIAL_VARIANCE

    def know(self, value: float, parameters: HoverThrustParameters) -> None:
        """Begin with a value that is known already."""
        self.value = value if parameters.learns else parameters.initial
        self._variance = PROCESS_NOISE

    def learn(
        self, thrust: float, acceleration_m_s2: float, parameters: HoverThrustParameters
    ) -> None:
        """Take in the upward thrust (0..1) of a tick and the upward acceleration that it gave."""
        if not parameters.learns:
            return
        hover, variance = self.value, self._variance + PROCESS_NOISE * TICK_S
        innovation = acceleration_m_s2 - GRAVITY_M_S2 * (thrust / hover - 1.0)
        slope = -GRAVITY_M_S2 * thrust / (hover * hover)
        gain = variance * slope / (slope * slope * variance + MEASUREMENT_VARIANCE)
        self._variance = variance * (1.0 - gain * slope)
        self.value = min(max(hover + gain * innovation, LIMITS[0]), LIMITS[1])
