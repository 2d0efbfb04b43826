"""Read ArduPilot's DataFlash with pymavlink's DFReader: its index and formats, columns by numpy."""

from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import Field
from flightstack.logs.errors import LogFileError
from flightstack.logs.onboard.ardupilot_events import find_texts
from flightstack.logs.onboard.ardupilot_messages import MAKERS
from flightstack.logs.onboard.topics import (
    LostBytes,
    OnboardRecords,
    TimedParameter,
    Times,
    Topic,
    plain_field,
)

Bytes = NDArray[np.uint8]

NUMPY_KINDS = {  # of a FMT's format characters; those with a scale are read as decimals
    "a": "<i2", "b": "i1", "B": "u1", "g": "<f2", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4",
    "f": "<f4", "n": "S4", "N": "S16", "Z": "S64", "c": "<i2", "C": "<u2", "e": "<i4", "E": "<u4",
    "L": "<i4", "d": "<f8", "M": "i1", "q": "<i8", "Q": "<u8",
}  # fmt: skip
TEXTS = "nNZ"
ARRAY_LENGTH = 32  # of "a"
DESCRIPTIONS = ("FMT", "FMTU", "UNIT", "MULT")  # say how records lie, and hold no data
PAD = (0x00, 0xFF)  # what flash holds after the last record
HEAD = 3  # two magic bytes and the type
GPS_EPOCH_S, LEAP_S, WEEK_S = 315_964_800, 18, 604_800


def _layout(form: Any) -> np.dtype[np.void] | None:
    """Return how a record's fields lie, None where the FMT contradicts itself."""
    characters = [c for c in form.format if c in NUMPY_KINDS]
    if len(characters) != len(form.columns) or len(set(form.columns)) != len(characters):
        return None
    layout = np.dtype(
        [
            (name, NUMPY_KINDS[c], (ARRAY_LENGTH,)) if c == "a" else (name, NUMPY_KINDS[c])
            for name, c in zip(form.columns, characters, strict=True)
        ]
    )
    return layout if layout.itemsize + HEAD == form.len else None


def _fields(form: Any) -> tuple[Field, ...]:
    units = form.units or [""] * len(form.columns)
    return tuple(
        plain_field(name, unit, is_text=c in TEXTS, length=ARRAY_LENGTH if c == "a" else 0)
        for name, unit, c in zip(form.columns, units, form.format, strict=False)
    )


def _gathered(raw: Bytes, offsets: Times, layout: np.dtype[np.void]) -> NDArray[np.void]:
    """Return the records at these places."""
    size = layout.itemsize
    views = np.lib.stride_tricks.sliding_window_view(raw, size)
    return np.ascontiguousarray(views[offsets + HEAD]).view(layout).reshape(-1)


def _scaled(data: NDArray[np.void], form: Any) -> NDArray[np.void]:
    """Return the records with the scales of their format: c, C, e, E hundredths, L 1e-7."""
    scales = dict(zip(form.columns, form.msg_mults, strict=False))
    halves = {name for name in form.columns if data.dtype[name].base == np.dtype("<f2")}
    if not halves and all(scale is None for scale in scales.values()):
        return data

    def kind(name: str) -> Any:
        wide = "<f8" if scales[name] is not None else "<f4" if name in halves else None
        return wide or data.dtype[name]

    wider = np.empty(len(data), dtype=[(name, kind(name)) for name in form.columns])
    for name in form.columns:
        scale = scales[name]
        wider[name] = data[name] if scale is None else data[name] / (1 / scale)
    return wider


def _own_times(name: str, data: NDArray[np.void]) -> Times | None:
    """Return the time since boot that the records carry, us; None where they carry none."""
    names = data.dtype.names or ()
    if names and names[0] == "TimeUS":
        return np.asarray(data["TimeUS"].astype(np.int64))
    if names and names[0] == "TimeMS":
        return np.asarray(data["TimeMS"].astype(np.int64) * 1000)
    return np.asarray(data["T"].astype(np.int64) * 1000) if name == "GPS" and "T" in names else None


class _Reading:
    """The records of one file by their name, with their places."""

    def __init__(self, reader: Any, raw: Bytes) -> None:
        self.offsets: dict[str, Times] = {}
        self.ends: dict[str, Times] = {}
        self.data: dict[str, NDArray[np.void]] = {}
        self.fields: dict[str, tuple[Field, ...]] = {}
        self.instance: dict[str, str] = {}
        for number, form in reader.formats.items():
            offsets = np.asarray(reader.offsets[number], dtype=np.int64)
            offsets = offsets[offsets + form.len <= len(raw)]
            layout = _layout(form)
            if not len(offsets) or layout is None:
                continue
            self.offsets[form.name] = offsets
            self.ends[form.name] = offsets + form.len
            if form.name not in DESCRIPTIONS and len(form.columns):
                self.data[form.name] = _scaled(_gathered(raw, offsets, layout), form)
                self.fields[form.name] = _fields(form)
                self.instance[form.name] = form.instance_field or ""

    def clock(self) -> tuple[Times, Times]:
        """Return the places of all records with a time, in order, and these times."""
        timed = [(self.offsets[n], t) for n, d in self.data.items()
                 if (t := _own_times(n, d)) is not None]  # fmt: skip
        if not timed:
            return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        places = np.concatenate([place for place, _ in timed])
        times = np.concatenate([time for _, time in timed])
        order = np.argsort(places)
        return places[order], times[order]


def _latest(clock: tuple[Times, Times], offsets: Times) -> Times:
    """Return the latest time told before each of these places; the first for those before it."""
    places, times = clock
    if not len(places):
        return np.zeros(len(offsets), dtype=np.int64)
    rows = np.maximum(np.searchsorted(places, offsets, side="right") - 1, 0)
    return np.asarray(times[rows])


def _split(topic: Topic, instance: str) -> dict[str, Topic]:
    """Return the topics of several units: the first under the name itself, then NAME_1, NAME_2."""
    numbers = topic.data[instance] if instance and topic.data[instance].dtype.kind in "iu" else None
    found = {}
    for number in [0] if numbers is None else np.unique(numbers).tolist():
        keep = slice(None) if numbers is None else numbers == number
        name = f"{topic.name}_{number}" if number else topic.name
        found[name] = Topic(
            name=name, fields=topic.fields, boot_us=topic.boot_us[keep], data=topic.data[keep]
        )
    return found


def _topics(reading: _Reading) -> dict[str, Topic]:
    clock = reading.clock()
    found: dict[str, Topic] = {}
    for name, data in sorted(reading.data.items()):
        own = _own_times(name, data)
        times = _latest(clock, reading.offsets[name]) if own is None else own
        order = np.argsort(times, kind="stable")
        topic = Topic(
            name=name, fields=reading.fields[name], boot_us=times[order], data=data[order]
        )
        found |= _split(topic, reading.instance[name])
    return found


def _lost(reading: _Reading, raw: Bytes) -> tuple[LostBytes, ...]:
    """Return the stretches between records, but for what flash is filled up with at the end."""
    starts = np.sort(np.concatenate(list(reading.offsets.values())))
    ends = np.sort(np.concatenate(list(reading.ends.values())))
    edges = np.append(starts, len(raw))
    before = np.insert(ends, 0, 0)
    gaps = np.flatnonzero(edges > before)
    times = _latest(reading.clock(), before[gaps])
    found = []
    for gap, time_us in zip(gaps.tolist(), times.tolist(), strict=True):
        start, stop = int(before[gap]), int(edges[gap])
        is_last = stop == len(raw)
        if is_last and np.isin(raw[start:stop], PAD).all():
            continue
        kind = "cut" if is_last else "foreign bytes"
        found.append(LostBytes(offset=start, length=stop - start, boot_us=time_us, kind=kind))
    return tuple(found)


def utc_offset_us(topics: dict[str, Topic]) -> int:
    """Return time since 1970 minus time since boot, as GPS told it; 0 where it did not."""
    gps = topics.get("GPS")
    if gps is None or not gps.has("GWk", "GMS"):
        return 0
    weeks = gps.data["GWk"].astype(np.int64)
    known = weeks > 0
    seconds = GPS_EPOCH_S - LEAP_S + weeks[known] * WEEK_S
    utc_us = seconds * 1_000_000 + gps.data["GMS"][known].astype(np.int64) * 1000
    return int(np.median(utc_us - gps.boot_us[known])) if known.any() else 0


def _parameters(topics: dict[str, Topic]) -> tuple[TimedParameter, ...]:
    table = topics.get("PARM")
    if table is None or not table.has("Name", "Value"):
        return ()
    rows = zip(table.boot_us.tolist(), table.data["Name"].tolist(), table.data["Value"].tolist(),
               strict=True)  # fmt: skip
    return tuple(
        TimedParameter(boot_us=time_us, name=name.decode("ascii", "replace"), value=float(value))
        for time_us, name, value in rows
    )


def _opened(path: str) -> Any:
    from pymavlink import DFReader  # noqa: PLC0415  # few logs are of this kind

    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            return DFReader.DFReader_binary(path)
    except Exception as error:  # DFReader raises Exception itself for a format that it cannot read
        raise LogFileError(f"{path} cannot be read as an ArduPilot .bin: {error}") from error


def read_dataflash(path: str) -> OnboardRecords:
    """Return all that a DataFlash log holds; LogFileError where it cannot be read, or is empty."""
    reader = _opened(path)
    raw = np.fromfile(path, dtype=np.uint8)
    try:
        reading = _Reading(reader, raw)
    finally:
        reader.close()
    if not reading.data:
        raise LogFileError(f"{path} is an ArduPilot .bin without any record: nothing was logged")
    topics = _topics(reading)
    parameters = _parameters(topics)
    system = {each.name: each.value for each in parameters}
    return OnboardRecords(
        name=path,
        size=Path(path).stat().st_size,
        topics=topics,
        system=int(system.get("SYSID_THISMAV", system.get("MAV_SYSID", 1))) & 0xFF,
        utc_offset_us=utc_offset_us(topics),
        makers=MAKERS,
        texts=tuple(find_texts(topics)),
        parameters=parameters,
        lost=_lost(reading, raw),
    )
