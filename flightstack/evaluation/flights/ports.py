"""Find ports that nobody uses: for flights side by side, and beside those of others.

Between finding and opening, another may take one; the flight then says so, and is flown again.
"""

import contextlib
import socket
from dataclasses import dataclass
from typing import Self

LOOPBACK = "127.0.0.1"


@dataclass(frozen=True, slots=True, kw_only=True)
class Ports:
    """The ports of one flight."""

    gcs_local: int  # UDP
    gcs_remote: int  # where no ground station listens
    api_local: int
    api_remote: int  # the companion's
    camera: int  # TCP

    @classmethod
    def find(cls) -> Self:
        """Let the kernel name free ones, all different."""
        with contextlib.ExitStack() as held:
            gcs_local, gcs_remote, api_local, api_remote = (
                _free(held, socket.SOCK_DGRAM) for _ in range(4)
            )
            camera = _free(held, socket.SOCK_STREAM)
        return cls(
            gcs_local=gcs_local,
            gcs_remote=gcs_remote,
            api_local=api_local,
            api_remote=api_remote,
            camera=camera,
        )


def _free(held: contextlib.ExitStack, kind: socket.SocketKind) -> int:
    probe = held.enter_context(socket.socket(socket.AF_INET, kind))
    probe.bind((LOOPBACK, 0))
    port: int = probe.getsockname()[1]
    return port
