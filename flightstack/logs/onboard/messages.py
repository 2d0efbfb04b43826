"""Make MAVLink messages of the dialect from columns, as the vehicle would have sent them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import message_id, message_type
from flightstack.logs.onboard.topics import Floats, Made, OnboardRecords, TimedText, Times, Topic

TEXT_BYTES = 50  # of a STATUSTEXT; longer ones are sent in chunks
MAX_TEXT_ID = 65_535
PARAM_INT32, PARAM_REAL32 = 6, 9  # MAV_PARAM_TYPE
ARMED = 128 | 1  # MAV_MODE_FLAG: armed, and custom modes
DISARMED = 1
CRITICAL, ACTIVE, STANDBY = 5, 4, 3  # MAV_STATE
ON_GROUND, IN_AIR = 1, 2  # MAV_LANDED_STATE


def _fitted(values: Any, kind: np.dtype[Any]) -> NDArray[Any]:
    """Return values as a field of this kind holds them: rounded, within its range, NaN as 0."""
    given = np.asarray(values)
    if kind.base.kind not in "iu" or given.dtype.kind != "f":
        return given
    limits = np.iinfo(kind.base)
    rounded = np.nan_to_num(np.rint(given), nan=0.0)
    return np.asarray(np.clip(rounded, limits.min, limits.max))


def make(name: str, boot_us: Times, **columns: Any) -> Made:
    """Return messages at these times; fields that are not given are 0, boot times are filled in."""
    known = message_type(message_id(name))
    if known is None:
        raise AssertionError(name)
    data = np.zeros(len(boot_us), dtype=known.dtype)
    names = data.dtype.names or ()
    if "time_boot_ms" in names:
        data["time_boot_ms"] = boot_us // 1000
    if "time_usec" in names:
        data["time_usec"] = boot_us
    for field, values in columns.items():
        data[field] = _fitted(values, data.dtype[field])
    return Made(boot_us=boot_us, data=data)


def at(times: Times, topic: Topic | None, values: Floats | None) -> Floats:
    """Return a topic's values at these times, linearly between its records; NaN without it."""
    if topic is None or values is None or not len(topic):
        width = () if values is None or values.ndim == 1 else values.shape[1:]
        return np.full((len(times), *width), np.nan)
    x, known = times.astype(np.float64), topic.boot_us.astype(np.float64)
    if values.ndim == 1:
        return np.interp(x, known, values)
    return np.stack([np.interp(x, known, column) for column in values.T], axis=1)


def euler(quaternions: Floats) -> Floats:
    """Return roll, pitch and yaw (n, 3) in rad of quaternions (n, 4): w, x, y, z, body to NED."""
    w, x, y, z = quaternions.T
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=1)


def _chunks(text: TimedText, number: int) -> list[tuple[int, int, bytes, int, int]]:
    """Return boot time, severity, bytes, id and chunk number of each message for a text."""
    raw = text.text.encode()
    pieces = [raw[start : start + TEXT_BYTES] for start in range(0, max(len(raw), 1), TEXT_BYTES)]
    text_id = number % MAX_TEXT_ID + 1 if len(pieces) > 1 else 0
    return [
        (text.boot_us, text.severity, piece, text_id, chunk) for chunk, piece in enumerate(pieces)
    ]


def status_texts(texts: Sequence[TimedText]) -> Made | None:
    """Return STATUSTEXT for texts."""
    rows = [row for number, text in enumerate(texts) for row in _chunks(text, number)]
    if not rows:
        return None
    times, severity, text, text_id, chunk = zip(*rows, strict=True)
    return make(
        "STATUSTEXT", np.array(times, dtype=np.int64), severity=np.array(severity),
        text=np.array(text, dtype=f"S{TEXT_BYTES}"), id=np.array(text_id),
        chunk_seq=np.array(chunk),
    )  # fmt: skip


def parameter_values(records: OnboardRecords) -> Made | None:
    """Return PARAM_VALUE for all parameters; integers in the bytes of the float, as PX4 does."""
    told = records.parameters
    if not told:
        return None
    is_integer = np.array([isinstance(each.value, int) for each in told])
    values = np.array([0.0 if isinstance(v.value, int) else v.value for v in told], dtype="<f4")
    integers = np.array([v.value if isinstance(v.value, int) else 0 for v in told])
    raw = np.where(is_integer, integers.astype("<i4"), values.view("<i4")).astype("<i4")
    return make(
        "PARAM_VALUE",
        np.array([each.boot_us for each in told], dtype=np.int64),
        param_id=np.array([each.name.encode()[:16] for each in told], dtype="S16"),
        param_value=raw.view("<f4"),
        param_type=np.where(is_integer, PARAM_INT32, PARAM_REAL32),
        param_count=np.full(len(told), len({each.name for each in told})),
        param_index=np.arange(len(told)) % 65_536,
    )
