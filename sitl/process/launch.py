"""Start a vehicle and run it until a signal.

The first HEARTBEAT goes out as soon as the links are open; what takes long to import comes after.
"""

import gc
import logging
import signal
import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from types import FrameType
from typing import TYPE_CHECKING

from sitl.errors import INTERRUPTED
from sitl.mavlink.links.link import Guard, Link
from sitl.mavlink.links.tcp_link import TcpLink
from sitl.mavlink.links.udp_client_link import UdpClientLink
from sitl.mavlink.links.udp_link import LinkConfig, UdpLink
from sitl.mavlink.streams.health import heartbeat
from sitl.mavlink.wire.signing import Signing
from sitl.process.options.command_line import Options
from sitl.process.options.signing_key import read_key, write_key
from sitl.process.quiet import quiet_outputs
from sitl.records.mavlink_numbers import MavState
from sitl.records.modes import Mode

if TYPE_CHECKING:
    from sitl.process.server import Server

_log = logging.getLogger(__name__)


def launch(options: Options) -> int:
    """Run one vehicle; returns the exit code.

    Raises:
        LinkError: a port cannot be had.
        UsageError: a parameter, the track's noise or the log's path cannot be.

    """
    unix_epoch_us = time.time_ns() // 1000
    with ExitStack() as stack:
        guard = _make_guard(options)
        links = _open_links(options, guard, stack)
        boot = heartbeat(Mode.HOLD.custom_mode, Mode.HOLD.base_mode, MavState.UNINIT)
        for link in links:
            link.send(boot)
        with quiet_outputs():
            from sitl.process.assembly import assemble  # noqa: PLC0415  brings pybullet and OpenCV

        server, stream = assemble(options, links, guard, unix_epoch_us, stack)
        _log.info("vehicle %d: %s, camera %s", options.system, _describe(links), stream.uri)
        if options.video is not None:
            _log.info("video to udp://%s:%d", *options.video)
        gc.freeze()  # what is here now stays: no need to look through it again and again
        return _run(server)


def _make_guard(options: Options) -> Guard:
    path = options.signing_key
    if path is None:
        return Guard()
    return Guard(signing=Signing(read_key(path), keep=lambda key: write_key(path, key)))


def _open_links(options: Options, guard: Guard, stack: ExitStack) -> list[Link]:
    links: list[Link] = []
    for index, (name, ports) in enumerate((("gcs", options.gcs_ports), ("api", options.api_ports))):
        config = LinkConfig(name=name, local_port=ports[0], remote_port=ports[1])
        link = UdpLink(config, system=options.system, index=index, guard=guard)
        links.append(stack.enter_context(closing(link)))
    for connect, addresses in ((UdpClientLink, options.udp), (TcpLink, options.tcp)):
        for address in addresses:
            further = connect(address, system=options.system, index=len(links), guard=guard)
            links.append(stack.enter_context(closing(further)))
    return links


def _describe(links: Sequence[Link]) -> str:
    return ", ".join(link.describe() for link in links)


def _run(server: "Server") -> int:
    """Run until SIGINT or SIGTERM; a second signal ends the process at once."""
    received: list[int] = []

    def stop(number: int, _frame: FrameType | None) -> None:
        received.append(number)
        signal.signal(number, signal.SIG_DFL)
        server.stop()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    server.run()
    _log.info("stopped by %s", signal.Signals(received[0]).name if received else "itself")
    return INTERRUPTED if signal.SIGINT in received else 0
