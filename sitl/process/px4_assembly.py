"""Be the simulator of a real PX4: physics, sensors, camera and referee around a connection."""

from collections.abc import Sequence
from contextlib import ExitStack, closing

from sitl.flown_vehicle import FlownVehicle
from sitl.hil.connection import Px4Connection
from sitl.hil.controller import HilController
from sitl.hil.endpoint import ComponentsEndpoint
from sitl.hil.relay import Relay
from sitl.mavlink.links.link import Guard, Link
from sitl.process.lockstep import Lockstep
from sitl.process.options.command_line import Options
from sitl.process.server import Server
from sitl.process.streams.camera_stream import CameraStream
from sitl.process.surroundings import describe_camera, keep_records, make_config


def assemble_px4(
    options: Options,
    connection: Px4Connection,
    relay: Relay | None,
    guard: Guard,
    unix_epoch_us: int,
    stack: ExitStack,
) -> tuple[Server, CameraStream]:
    """Build everything behind an open port; `stack` closes it.

    Raises:
        LinkError: the camera's port cannot be had.
        UsageError: the track's noise, a path or the display cannot be.

    """
    stream = stack.enter_context(closing(CameraStream(options.camera_port)))
    config = make_config(options)
    controller = HilController(connection, home=options.home, unix_epoch_us=unix_epoch_us)
    vehicle = FlownVehicle(
        config,
        lambda _airframe, _imu: controller,
        imu_noise_share=options.conditions.estimate.rotor_noise_share,
    )
    stack.enter_context(closing(vehicle))
    endpoint = ComponentsEndpoint(
        vehicle,
        connection,
        system=options.system,
        camera=describe_camera(stream.uri, options),
        guard=guard,
        relay=relay,
    )
    links: Sequence[Link] = () if relay is None else (relay[0],)
    server = Server(
        vehicle,
        endpoint,
        links,
        stream,
        speed_factor=options.speed_factor,
        lockstep=Lockstep(starts_free=True) if options.lockstep else None,
    )
    server.look_after(connection)
    if relay is not None:
        server.look_after(relay[1])
    keep_records(server, options, guard, stack, unix_epoch_us, lambda: vehicle.time_us)
    return server, stream
