"""Send what is known about each decision, so that it stands in every log beside its setpoint.

DEBUG_FLOAT_ARRAY "decision" carries all of it, four floats each, in the order of VELOCITIES:
aleatoric, epistemic and perceptual standard deviation, score, member, number of modes, command;
then the age of the image that it answers, when that was received.
NAMED_VALUE_FLOAT carries for plotting the length of each standard deviation over vx, vy, vz (m/s).
On request DEBUG_FLOAT_ARRAY "members" carries what each policy member predicts, four floats each.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import common

from flightstack.mavlink.link import Message
from flightstack.mavlink.offboard import TIME_WRAP_MS
from flightstack.records import ALL_MEMBERS, VELOCITIES, Decision

DECISION_NAME, DECISION_ID = b"decision", 0
MEMBERS_NAME, MEMBERS_ID = b"members", 1
ARRAY_FLOATS = 58
MAX_MEMBERS = ARRAY_FLOATS // len(VELOCITIES)  # more are left out
NAMED_PERIOD_US = 200_000  # 5 Hz
LINEAR = slice(0, 3)  # vx, vy, vz: one unit, so that a length means something


class UncertaintyPublisher:
    """Publish decisions through a link's `send`, with each member's prediction on request."""

    def __init__(self, send: Callable[[Message], None], *, with_members: bool = False) -> None:
        self._send = send
        self._with_members = with_members
        self._named_us: int | None = None

    def publish(self, decision: Decision, stamp_us: int, image_age_s: float = 0.0) -> None:
        """Send a decision's uncertainties, and at 5 Hz the three lengths."""
        self._send(_decision_array(decision, stamp_us, image_age_s))
        if self._with_members:
            self._send(_members_array(decision, stamp_us))
        if self._named_us is not None and 0 <= stamp_us - self._named_us < NAMED_PERIOD_US:
            return
        self._named_us = stamp_us
        stds = {
            b"unc_alea": decision.aleatoric_std,
            b"unc_epis": decision.epistemic_std,
            b"unc_perc": decision.perceptual_std,
        }
        for name, std in stds.items():
            stamp_ms = stamp_us // 1000 % TIME_WRAP_MS
            self._send(common.MAVLink_named_value_float_message(stamp_ms, name, linear_length(std)))


def linear_length(std: NDArray[np.float64]) -> float:
    """Length (m/s) of a standard deviation over the three linear velocities."""
    return float(np.linalg.norm(std[LINEAR]))


def total_std_m_s(decision: Decision) -> float:
    """All three kinds of uncertainty in one number: their root sum of squares, m/s."""
    kinds = (decision.aleatoric_std, decision.epistemic_std, decision.perceptual_std)
    return math.hypot(*map(linear_length, kinds))


def _decision_array(decision: Decision, stamp_us: int, image_age_s: float) -> Message:
    rows = (
        decision.aleatoric_std,
        decision.epistemic_std,
        decision.perceptual_std,
        _score_of_choice(decision),
        decision.member,
        decision.modes,
        decision.command,
        (image_age_s,),
    )
    return _array(np.concatenate(rows), stamp_us, DECISION_NAME, DECISION_ID)


def _members_array(decision: Decision, stamp_us: int) -> Message:
    values = decision.member_mean[:MAX_MEMBERS].ravel()
    return _array(values, stamp_us, MEMBERS_NAME, MEMBERS_ID)


def _array(values: NDArray[np.float64], stamp_us: int, name: bytes, number: int) -> Message:
    data = np.zeros(ARRAY_FLOATS)
    data[: values.size] = values
    return common.MAVLink_debug_float_array_message(stamp_us, name, number, data.tolist())


def _score_of_choice(decision: Decision) -> NDArray[np.float64]:
    """Pick each velocity's score of the chosen member; the mean where all were pooled."""
    chosen = decision.score[np.maximum(decision.member, 0), np.arange(decision.member.size)]
    return np.where(decision.member == ALL_MEMBERS, decision.score.mean(axis=0), chosen)
