"""Images without stamps are dated in the vehicle's time, however the link jitters."""

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from flightstack.camera.camera import Camera
from flightstack.camera.stamps import StampCheck
from flightstack.clock import VehicleClock
from flightstack.companion.opening.discovery import listen, wait_for_camera, wait_for_vehicle
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.companion.waiting import wait_for_any
from flightstack.launch.instances import free_instance
from flightstack.mavlink.endpoint import parse_endpoint
from flightstack.mavlink.link import Link
from flightstack.mavlink.tlog import TlogWriter
from flightstack.mavlink.transport import open_transport
from tests.flight.processes import process
from tests.wire.camera_proxy import CameraProxy, Unstamped
from tests.wire.companion.companion_trial import free_port
from tests.wire.jitter import JitteringProxy

pytestmark = pytest.mark.flight
LISTEN_S, LOOK_S, GLANCE_S = 4.0, 3.0, 1.5  # wall time
WITHIN_MS = 5.0
LOOKS = 4  # where others have the processor, images are handed on late, whatever the clock says


@contextlib.contextmanager
def flying_link(folder: Path, instance: int) -> Iterator[VehicleSession]:
    """A simulator in real time, and a session with it over a link with 40 +- 30 ms each way."""
    port = free_port()
    clock = VehicleClock()
    with JitteringProxy(port, low_s=0.01, high_s=0.07) as proxy:
        options = (f"--instance={instance}", f"--api-link=0:{proxy.vehicle_port}", "-q")
        with process("sitl", *options, log=folder / "vehicle.txt"):
            transport = open_transport(parse_endpoint(f"udpin:127.0.0.1:{port}"))
            link = Link(transport, TlogWriter(folder / "link.tlog", clock.wall_s), clock)
            session = VehicleSession(link, 3.0)
            wait_for_vehicle(session, 30.0, name="the jittering link")
            yield session
            link.close()


def errors_ms(
    session: VehicleSession, camera: Camera, true_us: dict[int, int], for_s: float
) -> list[float]:
    """How far off the images' dates are, one by one; telemetry is taken in as it comes."""
    check = StampCheck(session.link.clock)
    until_s = time.monotonic() + for_s
    errors = []
    while time.monotonic() < until_s:
        wait_for_any(0.1, session.link, camera)
        session.receive()
        session.keep_up(session.link.clock.stamp_us)
        arrival = camera.take()
        if arrival is not None:
            image = check.admit(arrival).image
            errors.append((image.stamp_us - true_us[image.sequence]) / 1e3)
    return errors


def test_images_without_stamps_agree_with_telemetry_over_a_link_that_jitters(
    tmp_path: Path,
) -> None:
    stripped = Unstamped()
    with free_instance() as instance, CameraProxy(stripped) as proxy:
        proxy.vehicle_instance = instance
        with flying_link(tmp_path, instance) as session:
            camera = wait_for_camera(session, proxy.uri, 10.0)
            by_telemetry = errors_ms(session, camera, stripped.true_us, GLANCE_S)
            session.timesync.begin()
            listen(session, LISTEN_S)
            for _ in range(LOOKS):
                by_timesync = errors_ms(session, camera, stripped.true_us, LOOK_S)
                if abs(np.median(by_timesync)) < WITHIN_MS:
                    break
            quality = session.timesync.quality
            camera.close()
    assert quality is not None
    assert quality.round_trip_s == pytest.approx(0.08, abs=0.02)
    assert len(by_timesync) > 0.7 * 20 * LOOK_S
    assert abs(np.median(by_timesync)) < WITHIN_MS
    assert np.median(by_telemetry) < -8.0  # what the link alone takes
