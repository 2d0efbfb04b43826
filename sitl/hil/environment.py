"""What a PX4 must know of our airframe, as environment variables of its own start script.

PX4 applies PX4_PARAM_<NAME> before the airframe's own defaults (`rcS`); what is not named here,
the gains above all, are PX4's defaults for a quadrotor, as in the emulated autopilot.
"""

from collections.abc import Mapping

from sitl.records.motion import Vector3
from sitl.world.airframe import Airframe

# The airframe of PX4 whose simulator is whoever listens, and whose four motors are ours in order.
MODEL = "none_iris"


def px4_environment(airframe: Airframe, home: Vector3) -> Mapping[str, str]:
    """Name the interface, and where the rotors sit, what hovers, and where home is."""
    named: dict[str, float] = {"MPC_THR_HOVER": airframe.hover_thrust}
    for rotor, (x_m, y_m) in enumerate(airframe.rotors.positions_frd_m):
        named[f"CA_ROTOR{rotor}_PX"] = x_m
        named[f"CA_ROTOR{rotor}_PY"] = y_m
    return {
        "PX4_SIM_MODEL": MODEL,
        **{
            f"PX4_HOME_{name}": f"{value:.9g}"
            for name, value in zip(("LAT", "LON", "ALT"), home, strict=True)
        },
        **{f"PX4_PARAM_{name}": f"{value:.4g}" for name, value in named.items()},
    }
