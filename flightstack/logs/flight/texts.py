"""Put STATUSTEXT messages together: chunks joined, copies from several links dropped."""

from dataclasses import dataclass, replace

from flightstack.logs.columns.log import Log
from flightstack.logs.dialect.message_types import enum_name

COPY_US = 200_000  # the same text from the same sender this soon came over another link


@dataclass(frozen=True, slots=True, kw_only=True)
class LoggedText:
    """One status text."""

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


def _pieces(log: Log) -> list[tuple[LoggedText, int, int]]:
    """Return each message as a text with its id and chunk number."""
    table = log["STATUSTEXT"]
    rows = zip(
        table.time_us.tolist(),
        table.system.tolist(),
        table.component.tolist(),
        table["severity"].tolist(),
        table["text"].tolist(),
        table["id"].tolist(),
        table["chunk_seq"].tolist(),
        strict=True,
    )
    return [
        (LoggedText(time_us=t, system=s, component=c, severity=v, text=text), text_id, chunk)
        for t, s, c, v, text, text_id, chunk in rows
    ]


def status_texts(log: Log) -> list[LoggedText]:
    """Return all status texts of all systems in order of time."""
    found: list[LoggedText] = []
    unfinished: dict[tuple[int, int, int], int] = {}  # (system, component, id): place in found
    last_seen: dict[tuple[int, int, int, str], int] = {}
    for piece, text_id, chunk in _pieces(log):
        copy = (piece.system, piece.component, chunk, piece.text)
        seen_us = last_seen.get(copy)
        last_seen[copy] = piece.time_us
        if seen_us is not None and 0 <= piece.time_us - seen_us < COPY_US:
            continue
        key = (piece.system, piece.component, text_id)
        if text_id and chunk and key in unfinished:
            place = unfinished[key]
            found[place] = replace(found[place], text=found[place].text + piece.text)
        else:
            unfinished[key] = len(found)
            found.append(piece)
    return [replace(text, text=text.text.rstrip("\t\n ")) for text in found]
