"""A simulated PX4-style vehicle: pybullet physics, an autopilot, a camera, MAVLink 2 over UDP.

`python -m sitl` runs it. As a library it is the simulation alone, a tick at a time, no sockets::

    from sitl import Conditions, CourseState, Simulation, SimulationConfig, Wind

    windy = Conditions(wind=Wind(mean_ned_m_s=(3.0, 0.0, 0.0)))
    simulation = Simulation(SimulationConfig(seed=1, conditions=windy))
    simulation.start_airborne((0.0, 0.0, -3.0), yaw_rad=0.0)
    while simulation.course.state is CourseState.ACTIVE:
        ...  # render() an image, hand an OffboardSetpoint to simulation.autopilot
        simulation.step()

The names below are all that others may import. Each is loaded when it is first used, so that what
needs no physics engine and no renderer loads none.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sitl.errors import SitlError, UsageError
    from sitl.flown_vehicle import SimulationConfig, look_of_day
    from sitl.frames import euler_from_quaternion, quaternion_from_euler, rotate, wrap_pi, yaw_of
    from sitl.records.conditions import (
        CameraFaults,
        Conditions,
        CourseDecoys,
        EstimateErrors,
        Light,
        Wind,
        parse_conditions,
    )
    from sitl.records.course import CourseState, Gate
    from sitl.records.gate import GATE_OUTER_M, GateShape
    from sitl.records.images import Image
    from sitl.records.motion import Quaternion, Vector3, VehicleState
    from sitl.records.scenery import Scenery
    from sitl.records.sensing import Estimate, Readings
    from sitl.records.vehicle import OffboardSetpoint
    from sitl.sensors.camera.camera import Camera
    from sitl.sensors.camera.feed import CAMERA_RATE_HZ
    from sitl.sensors.camera.look import GROUND_TEXTURES, Colour, Look, at_dusk, draw_look, in_fog
    from sitl.sensors.camera.picture import blurred
    from sitl.simulation import Simulation
    from sitl.world.track import (
        GATE_HEIGHT_M,
        GATES_PER_LAP,
        MAX_HEIGHT_NOISE_M,
        MAX_RADIUS_NOISE_M,
        Track,
        make_track,
    )

_MODULES = (  # where the names live, from light to heavy
    "errors",
    "frames",
    "records.conditions",
    "records.course",
    "records.gate",
    "records.images",
    "records.motion",
    "records.scenery",
    "records.sensing",
    "records.vehicle",
    "world.track",
    "sensors.camera.look",
    "sensors.camera.picture",
    "sensors.camera.camera",
    "sensors.camera.feed",
    "flown_vehicle",
    "simulation",
)
__all__ = [
    "CAMERA_RATE_HZ",
    "GATES_PER_LAP",
    "GATE_HEIGHT_M",
    "GATE_OUTER_M",
    "GROUND_TEXTURES",
    "MAX_HEIGHT_NOISE_M",
    "MAX_RADIUS_NOISE_M",
    "Camera",
    "CameraFaults",
    "Colour",
    "Conditions",
    "CourseDecoys",
    "CourseState",
    "Estimate",
    "EstimateErrors",
    "Gate",
    "GateShape",
    "Image",
    "Light",
    "Look",
    "OffboardSetpoint",
    "Quaternion",
    "Readings",
    "Scenery",
    "Simulation",
    "SimulationConfig",
    "SitlError",
    "Track",
    "UsageError",
    "Vector3",
    "VehicleState",
    "Wind",
    "at_dusk",
    "blurred",
    "draw_look",
    "euler_from_quaternion",
    "in_fog",
    "look_of_day",
    "make_track",
    "parse_conditions",
    "quaternion_from_euler",
    "rotate",
    "wrap_pi",
    "yaw_of",
]


def __getattr__(name: str) -> Any:
    """Load what has a name (PEP 562)."""
    if name in __all__:
        for module in _MODULES:
            names = vars(_load(f"sitl.{module}"))
            if name in names:
                return globals().setdefault(name, names[name])
    raise AttributeError(f"module 'sitl' has no attribute '{name}'")


def _load(module: str) -> ModuleType:
    if module not in sys.modules:
        from sitl.process.quiet import quiet_outputs  # noqa: PLC0415

        with quiet_outputs():  # pybullet greets whoever imports it
            return import_module(module)
    return sys.modules[module]
