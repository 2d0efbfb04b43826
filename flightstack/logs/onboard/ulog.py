"""Read PX4's ULog with pyulog: topics, texts, parameters, dropouts."""

import re
import struct
from collections.abc import Iterable, Iterator
from contextlib import redirect_stdout
from io import StringIO
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.libraries import load_library
from flightstack.logs.errors import LogFileError
from flightstack.logs.onboard.px4_messages import MAKERS
from flightstack.logs.onboard.topics import (
    Dropout,
    OnboardRecords,
    TimedParameter,
    TimedText,
    Topic,
    plain_field,
)

ELEMENT = re.compile(r"(.*)\[(\d+)\]")
TIME_FIELD = "timestamp"
BOOT_TIME = "boot_time_utc_us"  # of the head: the computer's clock in simulation
INFO = 6  # MAV_SEVERITY
ANSI_COLOUR = re.compile(r"\x1b\[[0-9;]*m")


def plain_name(name: str) -> str:
    """Return a field's name as an identifier: esc[0].rpm is esc_0_rpm."""
    return re.sub(r"\W+", "_", name).strip("_")


def _grouped(names: Iterable[str]) -> Iterator[tuple[str, list[str]]]:
    """Yield each field's name with those of its elements, itself where it is no array."""

    def base(name: str) -> str:
        found = ELEMENT.fullmatch(name)
        return found[1] if found else name

    for name, members in groupby(names, base):
        yield plain_name(name), list(members)


def _topic(name: str, dataset: Any) -> Topic | None:
    """Return a dataset as a topic, None where it carries no time."""
    columns: dict[str, NDArray[Any]] = dataset.data
    if TIME_FIELD not in columns or not len(columns[TIME_FIELD]):
        return None
    types = {each.field_name: each.type_str for each in dataset.field_data}
    times = columns[TIME_FIELD].astype(np.int64)
    order = np.argsort(times, kind="stable")
    fields, layout, parts = [], [], []
    for plain, members in _grouped(columns):
        is_text = types[members[0]] == "char"
        stacked = np.stack([columns[member] for member in members], axis=1)[order]
        length = len(members) if len(members) > 1 and not is_text else 0
        fields.append(plain_field(plain, "", is_text=is_text, length=length))
        if is_text:
            stacked = np.ascontiguousarray(stacked).view(f"S{len(members)}")
        many = stacked.shape[1]
        layout.append((plain, stacked.dtype, (many,)) if many > 1 else (plain, stacked.dtype))
        parts.append(stacked if many > 1 else stacked[:, 0])
    data = np.empty(len(times), dtype=np.dtype(layout))
    for field, part in zip(fields, parts, strict=True):
        data[field.name] = part
    return Topic(name=name, fields=tuple(fields), boot_us=times[order], data=data)


def _topics(log: Any) -> dict[str, Topic]:
    """Return the topics by name; the second of several instances is NAME_1."""
    found: dict[str, Topic] = {}
    for dataset in sorted(log.data_list, key=lambda each: (each.name, each.multi_id)):
        name = dataset.name if not dataset.multi_id else f"{dataset.name}_{dataset.multi_id}"
        topic = _topic(name, dataset)
        if topic is not None and name not in found:
            found[name] = topic
    return found


def _severity(level: int) -> int:
    """Return MAV_SEVERITY: ULog writes syslog's levels as digits."""
    return level - ord("0") if ord("0") <= level <= ord("7") else INFO


def _texts(log: Any) -> list[TimedText]:
    tagged = [each for messages in log.logged_messages_tagged.values() for each in messages]
    messages = sorted([*log.logged_messages, *tagged], key=lambda each: int(each.timestamp))
    return [
        TimedText(
            boot_us=int(each.timestamp),
            severity=_severity(each.log_level),
            text=ANSI_COLOUR.sub("", each.message).rstrip("\t\n\0 "),
        )
        for each in messages
    ]


def _number(value: Any) -> int | float:
    return int(value) if isinstance(value, int) else float(value)


def _parameters(log: Any) -> list[TimedParameter]:
    start_us = int(log.start_timestamp)
    first = [(start_us, name, value) for name, value in log.initial_parameters.items()]
    told = [*first, *log.changed_parameters]
    return [
        TimedParameter(boot_us=int(time_us), name=name, value=_number(value))
        for time_us, name, value in told
        if isinstance(value, int | float)
    ]


def utc_offset_us(topics: dict[str, Topic], told_us: int) -> int:
    """Return time since 1970 minus time since boot: as GPS told it, else as the log's head does."""
    for name in ("vehicle_gps_position", "sensor_gps"):
        topic = topics.get(name)
        if topic is not None and topic.has("time_utc_usec"):
            utc_us = topic.data["time_utc_usec"].astype(np.int64)
            known = utc_us > 0
            if known.any():
                return int(np.median(utc_us[known] - topic.boot_us[known]))
    return told_us


def _system(log: Any, topics: dict[str, Topic]) -> int:
    status = topics.get("vehicle_status")
    if status is not None and status.has("system_id") and status.data["system_id"][-1]:
        return int(status.data["system_id"][-1])
    return int(log.initial_parameters.get("MAV_SYS_ID", 1)) & 0xFF


def _opened(path: str) -> Any:
    """Return pyulog's log; what it prints of damage is told by its flag, too."""
    pyulog = load_library("pyulog", "logs")
    try:
        with redirect_stdout(StringIO()), Path(path).open("rb") as file:
            return pyulog.ULog(file)
    except (pyulog.exceptions.ULogException, ArithmeticError, AttributeError, LookupError, OSError,
            TypeError, ValueError, MemoryError, struct.error) as error:  # fmt: skip
        raise LogFileError(f"{path} cannot be read as a PX4 ULog: {error}") from error


def read_ulog(path: str) -> OnboardRecords:
    """Return all that a ULog holds; LogFileError where pyulog cannot read it, or it is empty."""
    log = _opened(path)
    topics = _topics(log)
    if not topics:
        raise LogFileError(f"{path} is a PX4 ULog without any data: nothing was logged")
    dropouts = [
        Dropout(boot_us=int(each.timestamp), duration_s=each.duration * 1e-3)
        for each in log.dropouts
    ]
    return OnboardRecords(
        name=path,
        size=Path(path).stat().st_size,
        topics=topics,
        system=_system(log, topics),
        utc_offset_us=utc_offset_us(topics, int(log.msg_info_dict.get(BOOT_TIME, 0))),
        makers=MAKERS,
        texts=tuple(_texts(log)),
        parameters=tuple(_parameters(log)),
        dropouts=tuple(dropouts),
        is_damaged=bool(log.file_corruption),
        versions={key: value for key, value in log.msg_info_dict.items()
                  if isinstance(value, int | str)},
    )  # fmt: skip
