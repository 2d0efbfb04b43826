"""Look at a vehicle that another simulator moves: camera and referee around a link of poses."""

from collections.abc import Sequence
from contextlib import ExitStack, closing

from sitl.external.followed_vehicle import FollowedVehicle
from sitl.external.pose_link import PoseLink
from sitl.hil.endpoint import ComponentsEndpoint
from sitl.hil.relay import Relay
from sitl.mavlink.links.link import Guard, Link
from sitl.process.options.command_line import Options
from sitl.process.server import Server
from sitl.process.streams.camera_stream import CameraStream
from sitl.process.surroundings import describe_camera, keep_records, make_config


def assemble_external(
    options: Options,
    link: Link,
    relay: Relay | None,
    guard: Guard,
    unix_epoch_us: int,
    stack: ExitStack,
) -> tuple[Server, CameraStream]:
    """Build everything behind an open link; `stack` closes it.

    Raises:
        LinkError: the camera's port cannot be had.
        UsageError: the track's noise, a path or the display cannot be.

    """
    stream = stack.enter_context(closing(CameraStream(options.camera_port)))
    origin = options.home if options.has_home else None
    poses = PoseLink(link, system=options.system, origin=origin)
    vehicle = FollowedVehicle(make_config(options), poses)
    stack.enter_context(closing(vehicle))
    endpoint = ComponentsEndpoint(
        vehicle,
        poses,
        system=options.system,
        camera=describe_camera(stream.uri, options),
        guard=guard,
        relay=relay,
    )
    links: Sequence[Link] = () if relay is None else (relay[0],)
    server = Server(vehicle, endpoint, links, stream, speed_factor=0.0)  # poses set the pace
    server.look_after(poses)
    server.each_second(poses.ask)
    if relay is not None:
        server.look_after(relay[1])
    keep_records(server, options, guard, stack, unix_epoch_us, lambda: vehicle.time_us)
    return server, stream
