"""Say in MAVLink what ArduPilot logs as events: modes, arming, landing, failsafes, texts."""

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.onboard.messages import (
    ACTIVE,
    ARMED,
    CRITICAL,
    DISARMED,
    IN_AIR,
    ON_GROUND,
    STANDBY,
    make,
)
from flightstack.logs.onboard.topics import Floats, Made, OnboardRecords, TimedText, Times, Topic

ARDUPILOT = 3  # MAV_AUTOPILOT
EVENT_ARMED, EVENT_DISARMED, EVENT_LANDED, EVENT_NOT_LANDED = 10, 11, 18, 28  # EV.Id
ERROR, INFO = 3, 6  # MAV_SEVERITY
BEAT_US = 1_000_000
# ERR.Subsys that are failsafes; ERR.ECode 0 ends one
FAILSAFES = {
    5: "radio", 6: "battery", 7: "GPS", 8: "ground station", 9: "fence", 16: "EKF check",
    17: "EKF", 20: "terrain",
}  # fmt: skip
COPTER_FRAMES = {2: 13, 3: 14, 4: 14, 5: 13, 6: 4, 7: 15}  # FRAME_CLASS: MAV_TYPE
QUADROTOR, PLANE, VTOL, ROVER, BOAT, SUB, TRACKER = 2, 1, 22, 10, 11, 12, 5
BOAT_FRAME = 2  # FRAME_CLASS of a rover
FIRMWARES = {  # first word of the text in which a firmware names itself
    "arducopter": QUADROTOR, "arduplane": PLANE, "ardurover": ROVER, "rover": ROVER,
    "ardusub": SUB, "antennatracker": TRACKER,
}  # fmt: skip


def _pairs(topic: Topic | None, name: str) -> tuple[Times, Floats]:
    """Return times and values of a field; nothing without the topic or the field."""
    if topic is None or not topic.has(name):
        return np.empty(0, dtype=np.int64), np.empty(0)
    return topic.boot_us, topic.column(name)


def held(times: Times, changes: tuple[Times, Floats], before: float) -> Floats:
    """Return at these times the value that was told last, `before` until the first."""
    told_at, values = changes
    place = np.searchsorted(told_at, times, side="right")
    return np.concatenate(([before], values))[place]


def _events(records: OnboardRecords, yes: int, no: int) -> tuple[Times, Floats]:
    """Return when an event made something true, 1, or another made it false, 0."""
    times, ids = _pairs(records.topic("EV"), "Id")
    known = np.isin(ids, (yes, no))
    return times[known], (ids[known] == yes).astype(np.float64)


def _arming(records: OnboardRecords) -> tuple[Times, Floats]:
    """Return when the vehicle was armed and disarmed: as ARM told it, else events, else STAT."""
    for name, field in (("ARM", "ArmState"), ("STAT", "Armed")):
        times, values = _pairs(records.topic(name), field)
        if len(times):
            return times, (values > 0).astype(np.float64)
    return _events(records, EVENT_ARMED, EVENT_DISARMED)


def _failing(records: OnboardRecords) -> tuple[Times, Floats]:
    """Return how many failsafes were on from when."""
    times, codes = _pairs(records.topic("ERR"), "ECode")
    _, systems = _pairs(records.topic("ERR"), "Subsys")
    now: set[int] = set()
    counts = []
    for system, code in zip(systems.tolist(), codes.tolist(), strict=True):
        if system in FAILSAFES:
            (now.add if code else now.discard)(int(system))
        counts.append(float(len(now)))
    return times, np.array(counts)


def vehicle_type(records: OnboardRecords) -> int:
    """Return MAV_TYPE, from what the firmware says of itself and its frame."""
    words = [re.split(r"\W", text.text.lower(), maxsplit=1)[0] for text in records.texts]
    kind = next((FIRMWARES[word] for word in words if word in FIRMWARES), None)
    frame = int(records.parameter("FRAME_CLASS", "Q_FRAME_CLASS") or 0)
    if kind is None:
        copter = records.topic("RATE", "PSCD", "CTUN") is not None
        kind = QUADROTOR if copter and records.parameter("FRAME_CLASS") is not None else 0
    if kind == PLANE and (records.parameter("Q_ENABLE") or 0) > 0:
        return VTOL
    if kind == ROVER and frame == BOAT_FRAME:
        return BOAT
    return COPTER_FRAMES.get(frame, kind) if kind == QUADROTOR else kind


def heartbeat(records: OnboardRecords) -> Made | None:
    """Return HEARTBEAT each second, and wherever mode, arming or a failsafe changed."""
    mode = _pairs(records.topic("MODE"), "ModeNum")
    if not len(mode[0]):
        mode = _pairs(records.topic("MODE"), "Mode")
    if not len(mode[0]):
        return None
    arming, failing = _arming(records), _failing(records)
    first = min(int(topic.boot_us[0]) for topic in records.topics.values())
    last = max(int(topic.boot_us[-1]) for topic in records.topics.values())
    steady = np.arange(first, last + 1, BEAT_US, dtype=np.int64)
    times = np.unique(np.concatenate([steady, mode[0], arming[0], failing[0]]))
    is_armed = held(times, arming, 0.0) > 0
    state: NDArray[np.int64] = np.where(is_armed, ACTIVE, STANDBY)
    kind = vehicle_type(records)
    return make(
        "HEARTBEAT", times, autopilot=np.full(len(times), ARDUPILOT),
        type=np.full(len(times), kind), base_mode=np.where(is_armed, ARMED, DISARMED),
        custom_mode=held(times, mode, float(mode[1][0])),
        system_status=np.where(held(times, failing, 0.0) > 0, CRITICAL, state),
    )  # fmt: skip


def landed(records: OnboardRecords) -> Made | None:
    """Return EXTENDED_SYS_STATE, from a copter's events or a plane's STAT; None without either."""
    times, aloft = _events(records, EVENT_NOT_LANDED, EVENT_LANDED)
    if len(times):  # what was before the first event is its opposite
        first = min(int(topic.boot_us[0]) for topic in records.topics.values())
        times, aloft = np.insert(times, 0, first), np.insert(aloft, 0, 1 - aloft[0])
    else:
        times, aloft = _pairs(records.topic("STAT"), "isFlying")
    if not len(times):
        return None
    return make("EXTENDED_SYS_STATE", times, landed_state=np.where(aloft > 0, IN_AIR, ON_GROUND))


def find_texts(topics: Mapping[str, Topic]) -> list[TimedText]:
    """Return the texts of MSG, and those that ERR stands for."""
    found = []
    messages, errors = topics.get("MSG"), topics.get("ERR")
    if messages is not None and messages.has("Message"):
        rows = zip(messages.boot_us.tolist(), messages.data["Message"].tolist(), strict=True)
        found += [
            TimedText(boot_us=t, severity=INFO, text=raw.split(b"\0")[0].decode("utf-8", "replace"))
            for t, raw in rows
        ]
    if errors is not None and errors.has("Subsys", "ECode"):
        columns = (errors.boot_us, errors.data["Subsys"], errors.data["ECode"])
        found += [_error(*row) for row in zip(*(each.tolist() for each in columns), strict=True)]
    return sorted(found, key=lambda text: text.boot_us)


def _error(boot_us: int, system: int, code: int) -> TimedText:
    name = FAILSAFES.get(system)
    if name is None:
        text = f"Error of subsystem {system}: code {code}" if code else f"Subsystem {system}: well"
    else:
        text = f"Failsafe: {name} (code {code})" if code else f"{name}: recovered"
    return TimedText(boot_us=boot_us, severity=ERROR if code else INFO, text=text)
