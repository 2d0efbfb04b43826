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
from sitl.process.options.external_options import ExternalOptions
from sitl.process.options.px4_options import Px4Options
from sitl.process.options.signing_key import read_key, write_key
from sitl.process.quiet import quiet_outputs
from sitl.records.mavlink_numbers import MavState
from sitl.records.modes import Mode

if TYPE_CHECKING:
    from sitl.hil.relay import Relay
    from sitl.process.server import Server

_log = logging.getLogger(__name__)


def launch(options: Options) -> int:
    """Run one vehicle, or print what a PX4 needs to know of it; returns the exit code.

    Raises:
        LinkError: a port cannot be had.
        UsageError: a parameter, the track's noise or the log's path cannot be.

    """
    unix_epoch_us = time.time_ns() // 1000
    if options.prints_px4_environment:
        _print_px4_environment(options)
        return 0
    with ExitStack() as stack:
        if options.px4 is not None:
            return _launch_px4(options, options.px4, unix_epoch_us, stack)
        if options.external is not None:
            return _launch_external(options, options.external, unix_epoch_us, stack)
        guard = _make_guard(options)
        links = _open_links(options, guard, stack)
        boot = heartbeat(Mode.HOLD.custom_mode, Mode.HOLD.base_mode, MavState.UNINIT)
        for link in links:
            link.send(boot)
        with quiet_outputs():
            from sitl.process.assembly import assemble  # noqa: PLC0415  brings pybullet and OpenCV

        server, stream = assemble(options, links, guard, unix_epoch_us, stack)
        about = f"vehicle {options.system}: {_describe(links)}, camera {stream.uri}"
        return _run(server, options, about)


def _launch_px4(options: Options, px4: Px4Options, unix_epoch_us: int, stack: ExitStack) -> int:
    from sitl.hil.connection import Px4Connection  # noqa: PLC0415  only a real PX4 needs it

    guard = Guard()
    connection = stack.enter_context(closing(Px4Connection(px4.hil_address)))
    relay = _open_relay(options, guard, stack) if px4.has_relay else None
    with quiet_outputs():
        from sitl.process.px4_assembly import assemble_px4  # noqa: PLC0415  brings pybullet

    server, stream = assemble_px4(options, connection, relay, guard, unix_epoch_us, stack)
    host, port = connection.address
    about = f"simulator of PX4 {options.instance}: tcp {host}:{port}, camera {stream.uri}"
    return _run(server, options, about)


def _launch_external(
    options: Options, external: ExternalOptions, unix_epoch_us: int, stack: ExitStack
) -> int:
    ears = Guard()  # of its own: what PX4 says in newer messages than ours is nobody's fault
    link: Link
    if external.kind == "udpin":
        host, port = external.address
        config = LinkConfig(name="poses", local_port=port, remote_port=0, host=host)
        link = UdpLink(config, system=options.system, index=0, guard=ears)
    else:
        link = UdpClientLink(external.address, system=options.system, index=0, guard=ears)
    stack.enter_context(closing(link))
    guard = Guard()
    relay = _open_relay(options, guard, stack) if external.has_relay else None
    with quiet_outputs():
        from sitl.process.external_assembly import assemble_external  # noqa: PLC0415  brings pybullet

    server, stream = assemble_external(options, link, relay, guard, unix_epoch_us, stack)
    about = f"follows vehicle {options.system}: {link.describe()}, camera {stream.uri}"
    return _run(server, options, about)


def _open_relay(options: Options, guard: Guard, stack: ExitStack) -> "Relay":
    from sitl.hil.relay import CompanionLink, Px4Side, relay_ports  # noqa: PLC0415  few need them

    px4_side = stack.enter_context(closing(Px4Side(relay_ports(options.instance))))
    local, remote = options.api_ports
    config = LinkConfig(name="relay", local_port=local, remote_port=remote)
    link = CompanionLink(config, px4_side, system=options.system, index=1, guard=guard)
    px4_side.link = stack.enter_context(closing(link))
    return link, px4_side


def _print_px4_environment(options: Options) -> None:
    from sitl.hil.environment import px4_environment  # noqa: PLC0415  nobody else needs it
    from sitl.world.airframe import load_airframe  # noqa: PLC0415

    for name, value in px4_environment(load_airframe("x500"), options.home).items():
        print(f"{name}={value}")


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


def _run(server: "Server", options: Options, about: str) -> int:
    """Say what runs, and run it until SIGINT or SIGTERM; a second one ends the process at once."""
    gc.freeze()  # what is here now stays: no need to look through it again and again
    received: list[int] = []

    def stop(number: int, _frame: FrameType | None) -> None:
        received.append(number)
        signal.signal(number, signal.SIG_DFL)
        server.stop()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    _log.info("%s", about)  # whoever reads this may end us: from here on we do so in order
    if options.video is not None:
        _log.info("video to udp://%s:%d", *options.video)
    server.run()
    _log.info("stopped by %s", signal.Signals(received[0]).name if received else "itself")
    return INTERRUPTED if signal.SIGINT in received else 0
