"""Give times to a stream without any: from the boot clock that its messages carry."""

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.payloads import gather
from flightstack.logs.dialect.message_types import message_type
from flightstack.logs.tlog.packets import Packets
from flightstack.logs.tlog.source import ByteSource

BOOT_FIELD = "time_boot_ms"


def _clock_rows(packets: Packets) -> tuple[int, NDArray[np.intp]]:
    """Return the message with a boot time that one sender sends most, and its rows; else none."""
    keys, counts = np.unique(
        packets.msgid.astype(np.int64) << 16 | packets.sender, return_counts=True
    )
    for key in keys[np.argsort(-counts)].tolist():
        known = message_type(key >> 16)
        if known is not None and any(field.name == BOOT_FIELD for field in known.fields):
            rows = np.flatnonzero((packets.msgid == key >> 16) & (packets.sender == key & 0xFFFF))
            return known.id, rows
    return -1, np.empty(0, dtype=np.intp)


def times_since_boot_us(source: ByteSource, packets: Packets) -> NDArray[np.int64]:
    """Return a time for every packet, since the vehicle's boot; zeros where nothing tells one."""
    msgid, rows = _clock_rows(packets)
    known = message_type(msgid)
    if known is None or not len(rows):
        return np.zeros(len(packets), dtype=np.int64)
    payloads = gather(source, {msgid: (packets.take(rows), known.size)})[msgid]
    boot_ms = payloads.reshape(-1).view(known.dtype)[BOOT_FIELD].astype(np.float64)
    times = np.interp(np.arange(len(packets)), rows, np.maximum.accumulate(boot_ms) * 1000)
    return np.asarray(times, dtype=np.int64)
