"""Put STATUSTEXT messages together: chunks joined, copies from several links dropped."""

from dataclasses import dataclass, field

from flightstack.logs.columns.log import Log
from flightstack.logs.dialect.message_types import enum_name
from flightstack.printable import printable

COPY_US = 200_000  # the same text from the same sender this soon came over another link
CHUNK_BYTES = 50  # a chunk this full has another one after it
LOST = "[...]"  # stands for chunks that are missing


@dataclass(frozen=True, slots=True, kw_only=True)
class LoggedText:
    """One status text, with control characters written out."""

    time_us: int
    system: int
    component: int
    severity: int  # MAV_SEVERITY: 0 emergency to 7 debug
    text: str

    @property
    def source(self) -> str:
        """Who said it: system/component."""
        return f"{self.system}/{self.component}"

    @property
    def level(self) -> str:
        """The severity's name, lower case."""
        return enum_name("MAV_SEVERITY", self.severity).removeprefix("MAV_SEVERITY_").lower()


@dataclass(slots=True)
class _Said:
    """One text while its chunks come in."""

    time_us: int
    sender: tuple[int, int]
    severity: int
    is_chunked: bool
    chunks: dict[int, bytes] = field(default_factory=dict)

    def whole(self) -> str:
        """Return the text: chunks that follow one another are one, as UTF-8."""
        last = max(self.chunks)
        parts: list[bytes] = []
        known = b""
        for number in range(last + 1):
            if number in self.chunks:
                known += self.chunks[number]
            elif known or not parts:
                parts += [known, LOST.encode()]
                known = b""
        parts.append(known)
        if self.is_chunked and len(self.chunks[last]) == CHUNK_BYTES:
            parts.append(LOST.encode())
        text = b" ".join(part for part in parts if part).decode(errors="replace")
        return printable(text.rstrip("\t\r\n "))


def status_texts(log: Log) -> list[LoggedText]:
    """Return all status texts of all systems in order of time."""
    table = log["STATUSTEXT"]
    columns = (table.data[name].tolist() for name in ("severity", "text", "id", "chunk_seq"))
    senders = zip(table.system.tolist(), table.component.tolist(), strict=True)
    found: list[_Said] = []
    unfinished: dict[tuple[tuple[int, int], int], _Said] = {}
    last_seen: dict[tuple[tuple[int, int], int, bytes], int] = {}
    for time_us, sender, severity, raw, text_id, chunk in zip(
        table.time_us.tolist(), senders, *columns, strict=True
    ):
        seen_us = last_seen.get((sender, chunk, raw))
        last_seen[sender, chunk, raw] = time_us
        if seen_us is not None and 0 <= time_us - seen_us < COPY_US:
            continue
        said = unfinished.get((sender, text_id)) if text_id and chunk else None
        if said is None or chunk <= max(said.chunks):
            said = _Said(time_us, sender, severity, is_chunked=text_id != 0)
            unfinished[sender, text_id] = said
            found.append(said)
        said.chunks[chunk if text_id else 0] = raw.split(b"\0", 1)[0]
    return [
        LoggedText(
            time_us=said.time_us,
            system=said.sender[0],
            component=said.sender[1],
            severity=said.severity,
            text=said.whole(),
        )
        for said in found
    ]
