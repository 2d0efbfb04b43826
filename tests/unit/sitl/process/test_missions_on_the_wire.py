"""The mission protocol and the autopilot together: whatever is taken can be flown."""

import math
from collections.abc import Iterator
from typing import Any, cast

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.mavlink.servers.missions.mission_server import MissionServer
from sitl.mavlink.vehicle import SimulatedVehicle
from sitl.records.missions import MissionResult, PlanKind
from sitl.records.modes import Mode
from sitl.records.texts import StatusText
from tests.unit.sitl.autopilot.conftest import HOME, Flight
from tests.unit.sitl.mavlink.fakes import FakeOutlet, make_request
from tests.unit.sitl.mavlink.servers.made_missions import count, item

WAYPOINT, LAND, RETURN, JUMP, CIRCLE, POLYGON = 16, 21, 20, 177, 5003, 5001
SET_MODE, MISSION_START = 176, 300
NAN = math.nan
NEAR = 10_000  # 1e-7 degrees: some 100 m


class Wired:
    """A vehicle in the air, and a client that uploads to it."""

    def __init__(self) -> None:
        self.flight = Flight()
        self.flight.place((0.0, 0.0, -6.0))
        self.flight.run(0.02)
        self.said: list[StatusText] = []
        self.told: list[Any] = []
        self._outlet = FakeOutlet()
        self._server = MissionServer(
            cast("SimulatedVehicle", self.flight), self.told.append, self.said.append
        )

    def upload(self, *items: Any, kind: int = 0) -> int:
        """The result; an upload ends at the first item that is refused."""
        request = make_request(self._outlet)
        self._server.count(count(len(items), kind), request)
        for message in items:
            self._server.item(message, request)
        result = next(m.type for m in self._outlet.take() if m.get_type() == "MISSION_ACK")
        return int(result)

    def fly(self, seconds: float) -> None:
        for _ in range(round(seconds * 250)):
            self.flight.step()
            self._server.advance()


@pytest.fixture
def wired() -> Iterator[Wired]:
    wired = Wired()
    yield wired
    wired.flight.close()


def near(sequence: int, command: int = WAYPOINT, **changes: Any) -> Any:
    """An item some metres from home."""
    x, y = round(HOME[0] * 1e7) + 400 * sequence, round(HOME[1] * 1e7)
    return item(sequence, command=command, **{"x": x, "y": y, "z": 6.0} | changes)


def test_progress_is_told_as_it_is_made(wired: Wired) -> None:
    assert wired.upload(near(0), near(1), near(2, RETURN, frame=2)) == MissionResult.ACCEPTED
    wired.fly(0.1)  # right after an upload in flight a start is refused
    assert wired.flight.command(SET_MODE, 1.0, 4.0, 4.0) == 0
    wired.fly(6.0)
    reached = [m.seq for m in wired.told if m.get_type() == "MISSION_ITEM_REACHED"]
    current = [
        (m.seq, m.total, m.mission_state, m.mission_mode)
        for m in wired.told
        if m.get_type() == "MISSION_CURRENT"
    ]
    assert reached == [0, 1, 2]
    assert current == [(0, 3, 2, 2), (1, 3, 3, 1), (2, 3, 5, 2)]


@pytest.mark.parametrize(
    ("items", "kind", "result"),
    [
        ([near(0, 9999)], 0, MissionResult.UNSUPPORTED),
        ([near(0), near(1, x=2**31 - 1)], 0, MissionResult.INVALID_PARAM5_X),
        (
            [near(0), near(1, JUMP, frame=2, param1=7.0, param2=1.0)],
            0,
            MissionResult.INVALID_PARAM1,
        ),
        ([item(0, 1, command=CIRCLE, param1=-3.0)], 1, MissionResult.INVALID_PARAM1),
        ([item(n, 1, command=POLYGON, param1=4.0) for n in range(3)], 1, MissionResult.INVALID),
        ([item(0, 2, command=WAYPOINT)], 2, MissionResult.UNSUPPORTED),
    ],
)
def test_what_is_refused_leaves_the_old_plan(
    wired: Wired, items: list[Any], kind: int, result: MissionResult
) -> None:
    wired.upload(near(0), near(1))
    assert wired.upload(*items, kind=kind) == result
    missions = wired.flight.autopilot.missions
    assert len(missions.plan(PlanKind.MISSION)) == 2
    assert missions.plan(PlanKind.FENCE) == missions.plan(PlanKind.RALLY) == ()


numbers = st.floats(-10.0, 10.0, width=32) | st.floats(width=32)
here = st.integers(-NEAR, NEAR)
places = st.builds(
    lambda command, x, y, z, p, q, r: {
        "command": command,
        "x": round(HOME[0] * 1e7) + x,
        "y": round(HOME[1] * 1e7) + y,
        "z": z,
        "param1": p,
        "param2": q,
        "param4": r,
    },
    st.sampled_from([16, 17, 19, 20, 21, 22, 31, 93, 177, 178, 201]),
    here,
    here,
    numbers,
    *(numbers, numbers, numbers),
)


@given(st.lists(places, min_size=1, max_size=6), st.integers(0, 5))
@settings(deadline=None, max_examples=25)
def test_whatever_is_taken_can_be_flown(items: list[dict[str, Any]], first: int) -> None:
    wired = Wired()
    result = wired.upload(*(item(n, **changes) for n, changes in enumerate(items)))
    wired.fly(0.1)
    wired.flight.command(MISSION_START, float(first))
    wired.fly(1.0)
    status = wired.flight.autopilot.status
    assert status.armed
    if result == MissionResult.ACCEPTED and first < len(items):
        assert status.mode in {Mode.MISSION, Mode.RTL}
    assert math.dist(wired.flight.estimate.position_ned, (0.0, 0.0, -6.0)) < 6.0
    wired.flight.close()
