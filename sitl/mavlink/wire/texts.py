"""Cut texts into STATUSTEXT messages as PX4 does."""

from sitl.mavlink.wire.dialect import Message, mavlink

CHUNK_BYTES = 50
TAB = "\t"  # PX4 ends its own texts so, to tell them from events


def statustexts(severity: int, text: str, text_id: int) -> list[Message]:
    """Make the chunks of one text: same id, chunk_seq 0, 1, ...; the last is never full."""
    encoded = text.encode("utf-8", errors="replace")
    chunks = [encoded[i : i + CHUNK_BYTES] for i in range(0, len(encoded) + 1, CHUNK_BYTES)]
    return [
        mavlink.MAVLink_statustext_message(severity, chunk, text_id, number)
        for number, chunk in enumerate(chunks[:256])
    ]
