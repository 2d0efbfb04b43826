"""Give times to a stream without any: from the boot clock that its messages carry."""

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.payloads import gather
from flightstack.logs.dialect.message_types import message_type
from flightstack.logs.tlog.frames import Frames
from flightstack.logs.tlog.source import Source

BOOT_FIELD = "time_boot_ms"


def _clock_rows(frames: Frames) -> tuple[int, NDArray[np.intp]]:
    """Return the message with a boot time that one sender sends most, and its rows; else none."""
    sender = frames.system.astype(np.int64) << 8 | frames.component
    keys, counts = np.unique(frames.msgid.astype(np.int64) << 16 | sender, return_counts=True)
    for key in keys[np.argsort(-counts)].tolist():
        known = message_type(key >> 16)
        if known is not None and any(field.name == BOOT_FIELD for field in known.fields):
            rows = np.flatnonzero((frames.msgid == key >> 16) & (sender == key & 0xFFFF))
            return known.id, rows
    return -1, np.empty(0, dtype=np.intp)


def times_since_boot_us(source: Source, frames: Frames) -> NDArray[np.int64]:
    """Return a time for every frame, since the vehicle's boot; zeros where nothing tells one."""
    msgid, rows = _clock_rows(frames)
    known = message_type(msgid)
    if known is None or not len(rows):
        return np.zeros(len(frames), dtype=np.int64)
    payloads = gather(source, {msgid: (frames.take(rows), known.size)})[msgid]
    boot_ms = payloads.reshape(-1).view(known.dtype)[BOOT_FIELD].astype(np.float64)
    times = np.interp(np.arange(len(frames)), rows, np.maximum.accumulate(boot_ms) * 1000)
    return np.asarray(times, dtype=np.int64)
