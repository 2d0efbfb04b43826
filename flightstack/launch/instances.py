"""Hold an instance of the vehicle whose ports are free: several flights may run side by side."""

import contextlib
import fcntl
import os
import socket
import tempfile
from collections.abc import Iterator
from pathlib import Path

from flightstack.errors import LinkError

INSTANCES = 10  # PX4 gives every instance its own offboard API port up to 14549
API_PORT = 14540  # the companion's end, + instance
PORTS_UDP = (18570, 14580, API_PORT)  # vehicle's GCS and API links, companion; + instance
CAMERA_PORT = 8090  # + instance
PX4_PORTS_UDP = (14280, 13030)  # a real PX4's links to camera and gimbal; + instance
HIL_PORT = 4560  # where a real PX4 finds its simulator; + instance
LOOPBACK = "127.0.0.1"


@contextlib.contextmanager
def free_instance(*, real_px4: bool = False) -> Iterator[int]:
    """Hold the first instance whose ports are free, against other flights of this user too.

    A real PX4 needs more of them.

    Raises LinkError where there is none.
    """
    for instance in range(INSTANCES):
        name = f"flightstack-{os.getuid()}-{instance}.lock"
        with Path(tempfile.gettempdir(), name).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            if _ports_free(instance, real_px4=real_px4):
                yield instance
                return
    last = API_PORT + INSTANCES - 1
    raise LinkError(f"UDP ports {API_PORT} to {last} are all taken: end another flight first")


def _ports_free(instance: int, *, real_px4: bool) -> bool:
    udp = (*PORTS_UDP, *PX4_PORTS_UDP) if real_px4 else PORTS_UDP
    tcp = (CAMERA_PORT, HIL_PORT) if real_px4 else (CAMERA_PORT,)
    kinds = {socket.SOCK_DGRAM: udp, socket.SOCK_STREAM: tcp}
    for kind, port in ((kind, port + instance) for kind, ports in kinds.items() for port in ports):
        with socket.socket(socket.AF_INET, kind) as probe:
            if kind == socket.SOCK_STREAM:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((LOOPBACK, port))
            except OSError:
                return False
    return True
