"""The quadrotor of PX4's simulator (SIH, airframe 10040), as it was observed, with little drag.

The observed parameters say all of it: SIH_MASS, SIH_IXX to SIH_IZZ, SIH_T_MAX, SIH_Q_MAX,
SIH_L_ROLL, SIH_L_PITCH, SIH_KDW, SIH_T_TAU, MPC_THR_HOVER. SIH_KDV is 1 by default; the steps that
are compared were flown with 0.1. The same torque, as a share of the greatest, turns an x500 1.7
times as fast.
"""

import dataclasses
import math

from sitl.world.airframe import Airframe, Drag, Rotors, load_airframe

THRUST_MAX_N, MOMENT_MAX_N_M, LEVER_M = 5.0, 0.1, 0.2
ROTOR_MAX_RAD_S = 1000.0  # only its share counts
DRAG_N_S_M, ANGULAR_DRAG_N_M_S = 0.1, 0.025
TIME_CONSTANT_S = 0.05


def load_sih(name: str) -> Airframe:
    """Load an airframe and make it PX4's."""
    airframe = load_airframe(name)
    a, b, c, d = (
        (math.copysign(LEVER_M, x), math.copysign(LEVER_M, y))
        for x, y in airframe.rotors.positions_frd_m
    )
    return dataclasses.replace(
        airframe,
        mass_kg=1.0,
        inertia_kg_m2=(0.025, 0.025, 0.03),
        rotors=Rotors(
            positions_frd_m=(a, b, c, d),
            directions=airframe.rotors.directions,
            thrust_coefficient_n_s2=THRUST_MAX_N / ROTOR_MAX_RAD_S**2,
            moment_coefficient_m=MOMENT_MAX_N_M / THRUST_MAX_N,
            max_speed_rad_s=ROTOR_MAX_RAD_S,
            time_constant_up_s=TIME_CONSTANT_S,
            time_constant_down_s=TIME_CONSTANT_S,
            drag_coefficient_n_s2_m=0.0,
        ),
        drag=Drag(linear_n_s_m=(DRAG_N_S_M,) * 3, angular_n_m_s=(ANGULAR_DRAG_N_M_S,) * 3),
        parameters={**airframe.parameters, "MPC_THR_HOVER": 0.5},
    )
