"""Another vehicle on the companion's port, heard first: the one with the camera is flown."""

import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.mission.records import Outcome
from tests.wire.companion.companion_trial import Trial
from tests.wire.fake_vehicle import Script

pytestmark = pytest.mark.flight
PX4, ARDUPILOT = 12, 3


@contextmanager
def beating(port: int, system: int, autopilot: int) -> Iterator[threading.Event]:
    """Be a vehicle that is armed, flies, and has no camera; the event says that it is heard."""
    protocol = common.MAVLink(None, system, 1)
    heard, over = threading.Event(), threading.Event()

    def beat(speaker: socket.socket) -> None:
        arrived = 0
        while not over.wait(0.05):
            message = common.MAVLink_heartbeat_message(2, autopilot, 0xD1, 0x00040000, 4, 3)
            try:
                speaker.send(message.pack(protocol))
                arrived += 1
            except ConnectionRefusedError:  # of the one before: nobody listens yet
                arrived = 0
            if arrived > 2:
                heard.set()

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as speaker:
        speaker.connect(("127.0.0.1", port))
        thread = threading.Thread(target=beat, args=(speaker,))
        thread.start()
        try:
            yield heard
        finally:
            over.set()
            thread.join()


@pytest.mark.parametrize(
    ("system", "autopilot", "named"),
    [(2, PX4, None), (1, PX4, None), (2, ARDUPILOT, None), (2, PX4, 1)],
    ids=["another PX4", "of the same number", "an ArduPilot", "--system"],
)
def test_the_vehicle_with_a_camera_is_flown(
    system: int, autopilot: int, named: int | None, tmp_path: Path
) -> None:
    trial = Trial(tmp_path, Script(gates=1), system=named)
    with beating(trial.plan.endpoint.port, system, autopilot) as heard, ExitStack() as stack:

        def begin() -> None:
            heard.wait(20.0)
            stack.enter_context(trial.vehicle)

        beginning = threading.Thread(target=begin)
        beginning.start()
        summary = trial.fly_alone()
        beginning.join()
    assert summary.outcome is Outcome.COMPLETED
    assert "vehicle 1 found" in trial.output.getvalue()
    assert f"looked past: system {system} at 127.0.0.1:" in trial.output.getvalue()
    assert not trial.vehicle.armed
