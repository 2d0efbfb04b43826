"""Run a vehicle with the drag of PX4's built-in simulator: SIH_KDV 1.0, 1 N/(m/s) for each kg.

Beside the rotors' own drag, which lies in their plane and grows with their speed.
"""

import dataclasses
import math
import sys

import sitl.flown_vehicle
from sitl.process.cli import main
from sitl.world.airframe import Airframe, load_airframe

SIH_DRAG_1_S = 1.0  # SIH_KDV over SIH_MASS
ROTORS = 4


def load_draggy(name: str) -> Airframe:
    """Load an airframe and add the frame's drag that it has too little of."""
    airframe = load_airframe(name)
    hover_rad_s = airframe.rotors.max_speed_rad_s * math.sqrt(airframe.hover_thrust)
    wanted = SIH_DRAG_1_S * airframe.mass_kg
    in_plane = wanted - ROTORS * airframe.rotors.drag_coefficient_n_s2_m * hover_rad_s
    return dataclasses.replace(
        airframe, drag=dataclasses.replace(airframe.drag, linear_n_s_m=(in_plane, in_plane, wanted))
    )


if __name__ == "__main__":
    setattr(sitl.flown_vehicle, "load_airframe", load_draggy)  # noqa: B010  its own, imported name
    sys.exit(main())
