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


class HoverThrust(NamedTuple):
    """The estimate and its variance."""

    value: float  # 0..1
    variance: float

    @classmethod
    def begin(cls, parameters: HoverThrustParameters, known: float | None = None) -> Self:
        """Begin anew, or know the value already."""
        if known is None:
            return cls(parameters.initial, INITIAL_VARIANCE)
        return cls(known if parameters.learns else parameters.initial, PROCESS_NOISE)

    def learn(
        self, thrust: float, acceleration_m_s2: float, parameters: HoverThrustParameters
    ) -> "HoverThrust":
        """Take in the upward thrust (0..1) of a tick and the upward acceleration that it gave."""
        if not parameters.learns:
            return self
        hover, variance = self
        variance += PROCESS_NOISE * TICK_S
        innovation = acceleration_m_s2 - GRAVITY_M_S2 * (thrust / hover - 1.0)
        slope = -GRAVITY_M_S2 * thrust / (hover * hover)
        gain = variance * slope / (slope * slope * variance + MEASUREMENT_VARIANCE)
        variance *= 1.0 - gain * slope
        return HoverThrust(min(max(hover + gain * innovation, LIMITS[0]), LIMITS[1]), variance)
