"""Fly in lockstep past a camera that is changed on its way."""

import json
from pathlib import Path
from typing import Any

from tests.flight import tlogs
from tests.flight.processes import ENDS_S, pair
from tests.wire.camera_proxy import CameraProxy, Change

LIMIT_S = 60.0


def fly_past(folder: Path, change: Change, *options: str) -> tuple[dict[str, Any], str, int, Any]:
    """Fly a lap past a camera; the result, all that was said, the code, the vehicle's log."""
    with CameraProxy(change) as proxy:
        companion = (f"--camera={proxy.uri}", "--json", *options)
        with pair(folder, "--noise=0,0", companion=companion) as flight:
            proxy.vehicle_instance = flight.instance
            code = flight.companion.wait(LIMIT_S)
            flight.vehicle.terminate()
            flight.vehicle.wait(ENDS_S)
            said = flight.companion_output.read_text()
    messages = tlogs.of_type(tlogs.read(flight.vehicle_log), "HEARTBEAT")
    beats = [m for m in messages if m.get_srcComponent() == 1]
    assert not beats[-1].base_mode & 128, "the vehicle is left armed"
    return json.loads(said.splitlines()[-1]), said, code, proxy.connections
