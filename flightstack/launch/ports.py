"""The ports on which a flight's two processes meet: an instance's, or any that nobody uses."""

import contextlib
import socket
from dataclasses import dataclass
from typing import Self

from flightstack.launch.instances import API_PORT, LOOPBACK


@dataclass(frozen=True, slots=True, kw_only=True)
class Ports:
    """What either process is told of them."""

    vehicle_options: tuple[str, ...]
    companion: int  # UDP
    instance: int = 0  # of a real PX4, which is told nothing else

    @classmethod
    def of_instance(cls, instance: int) -> Self:
        """Return those that PX4 gives an instance, which `free_instance` holds."""
        return cls(vehicle_options=(f"--instance={instance}",), companion=API_PORT + instance)

    @classmethod
    def of_px4_instance(cls, instance: int) -> Self:
        """Return those of an instance whose PX4 is a real one: its companion's go through ours."""
        with contextlib.ExitStack() as held:
            companion = _free(held, socket.SOCK_DGRAM)
        return cls(
            vehicle_options=(f"--instance={instance}", f"--api-link=0:{companion}"),
            companion=companion,
            instance=instance,
        )

    @classmethod
    def find(cls) -> Self:
        """Let the kernel name free ones, all different, for any number of flights side by side.

        Between finding and opening, another may take one; the flight then says so, and dies.
        """
        with contextlib.ExitStack() as held:
            gcs_local, gcs_remote, api_local, companion = (
                _free(held, socket.SOCK_DGRAM) for _ in range(4)
            )
            camera = _free(held, socket.SOCK_STREAM)
        return cls(
            vehicle_options=(
                f"--gcs-link={gcs_local}:{gcs_remote}",  # where no ground station listens
                f"--api-link={api_local}:{companion}",
                f"--camera-port={camera}",
            ),
            companion=companion,
        )


def _free(held: contextlib.ExitStack, kind: socket.SocketKind) -> int:
    probe = held.enter_context(socket.socket(socket.AF_INET, kind))
    probe.bind((LOOPBACK, 0))
    port: int = probe.getsockname()[1]
    return port
