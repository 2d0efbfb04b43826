"""Put a vehicle together: the simulation, its camera stream, its endpoint, and the loop."""

from collections.abc import Sequence
from contextlib import ExitStack, closing

from sitl.autopilot.parameters import Parameters, ParameterType
from sitl.mavlink.endpoint import Endpoint
from sitl.mavlink.links.link import Guard, Link
from sitl.mavlink.servers.files.storage import Storage
from sitl.process.lockstep import Lockstep
from sitl.process.options.command_line import Options
from sitl.process.options.parameter_file import ParameterFile
from sitl.process.server import Server
from sitl.process.streams.camera_stream import CameraStream
from sitl.process.surroundings import describe_camera, keep_records, make_config
from sitl.process.vehicle_folder import vehicle_folder
from sitl.simulation import Simulation


def assemble(
    options: Options, links: Sequence[Link], guard: Guard, unix_epoch_us: int, stack: ExitStack
) -> tuple[Server, CameraStream]:
    """Build everything behind open links; `stack` closes it.

    Raises:
        LinkError: the camera's port cannot be had.
        UsageError: a parameter, the track's noise, a path or the display cannot be.

    """
    stream = stack.enter_context(closing(CameraStream(options.camera_port)))
    simulation = stack.enter_context(closing(_make_simulation(options)))
    kept = _set_parameters(options, simulation.parameters)
    endpoint = Endpoint(
        simulation,
        links,
        system=options.system,
        camera=describe_camera(stream.uri, options),
        unix_epoch_us=unix_epoch_us,
        guard=guard,
        storage=stack.enter_context(
            closing(_make_storage(options, simulation, unix_epoch_us, stack))
        ),
    )
    stack.callback(endpoint.close)
    server = Server(
        simulation,
        endpoint,
        links,
        stream,
        speed_factor=options.speed_factor,
        lockstep=Lockstep() if options.lockstep else None,
    )
    keep_records(server, options, guard, stack, unix_epoch_us, lambda: simulation.time_us)
    if kept is not None:
        server.each_second(kept.save)
        stack.callback(kept.save)
    return server, stream


def _make_simulation(options: Options) -> Simulation:
    return Simulation(make_config(options))


def _set_parameters(options: Options, parameters: Parameters) -> ParameterFile | None:
    """Take the kept parameters, then those of the environment."""
    kept = None if options.params is None else ParameterFile(options.params, parameters)
    for name, text in options.parameters.items():
        parameters.set_from_text(name, text)
    parameters.set("MAV_SYS_ID", options.system)
    return kept


def _make_storage(
    options: Options, simulation: Simulation, unix_epoch_us: int, stack: ExitStack
) -> Storage:
    folder = options.files
    if folder is None:
        folder = stack.enter_context(vehicle_folder())
    return Storage(
        folder,
        parameters=_describe_parameters(simulation.parameters),
        unix_epoch_us=unix_epoch_us,
        clock=lambda: simulation.time_us,
    )


def _describe_parameters(parameters: Parameters) -> list[dict[str, str | float]]:
    """Put the parameters into the words of MAVLink's parameter metadata."""
    return [
        {
            "name": spec.name,
            "type": "Int32" if spec.type is ParameterType.INT32 else "Float",
            "group": spec.name.partition("_")[0],
            "default": spec.default,
            "min": spec.minimum,
            "max": spec.maximum,
            "units": spec.unit,
        }
        for spec in map(parameters.specification, parameters.names())
    ]
