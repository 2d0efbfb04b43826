"""Mission items between the wire and their record, in the integer and in the float message."""

import math

from sitl.mavlink.servers.request import Request
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.records.mavlink_numbers import GLOBAL_FRAMES, INT32_MAX, INT_TWINS, NOT_GIVEN
from sitl.records.missions import MissionItem, MissionResult, PlanKind

SCALE = 1e7


def read_item(message: Message) -> MissionItem | MissionResult:
    """Read MISSION_ITEM_INT or MISSION_ITEM; a result where a number cannot be meant."""
    params = (message.param1, message.param2, message.param3, message.param4)
    for number, value in enumerate((*params, message.z)):
        if math.isinf(value):
            return _invalid(number if number < len(params) else 6)
    x, y = message.x, message.y
    if message.get_msgId() == mavlink.MAVLINK_MSG_ID_MISSION_ITEM:
        scale = SCALE if message.frame in GLOBAL_FRAMES else 1.0
        for number, value in ((4, x), (5, y)):
            if not abs(value * scale) <= INT32_MAX:  # NaN, too
                return _invalid(number)
        x, y = round(x * scale), round(y * scale)
    return MissionItem(
        command=message.command,
        frame=message.frame,
        params=params,
        x=x,
        y=y,
        z=message.z,
        autocontinue=bool(message.autocontinue),
    )


def write_item(
    item: MissionItem, *, kind: PlanKind, sequence: int, current: bool, request: Request
) -> Message:
    """Write MISSION_ITEM_INT with the numbers that were uploaded."""
    return mavlink.MAVLink_mission_item_int_message(
        *_envelope(item, sequence, item.frame, request, current=current),
        item.x,
        item.y,
        item.z,
        kind,
    )


def write_float_item(
    item: MissionItem, *, kind: PlanKind, sequence: int, current: bool, request: Request
) -> Message:
    """Write MISSION_ITEM, for those who ask by MISSION_REQUEST."""
    scale = SCALE if item.frame in GLOBAL_FRAMES else 1.0
    frame = INT_TWINS.get(item.frame, item.frame)
    x, y = (math.nan if v == NOT_GIVEN else v / scale for v in (item.x, item.y))
    return mavlink.MAVLink_mission_item_message(
        *_envelope(item, sequence, frame, request, current=current), x, y, item.z, kind
    )


def _envelope(
    item: MissionItem, sequence: int, frame: int, request: Request, *, current: bool
) -> tuple[float, ...]:
    head = (request.system, request.component, sequence, frame, item.command)
    return (*head, int(current), int(item.autocontinue), *item.params)


def _invalid(number: int) -> MissionResult:
    """Name parameter `number`, counted from 0, as what is wrong."""
    return MissionResult(MissionResult.INVALID_PARAM1 + number)
