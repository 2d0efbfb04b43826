"""Tell which outputs of a vehicle are motors: by its parameters, else by its type alone.

Thrusters of boats and submarines turn both ways, so their limits are no saturation: none are told.
"""

from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.modes import PX4
from flightstack.logs.flight.outings import FLIGHT
from flightstack.logs.flight.parameters import read_parameters

OUTPUTS = range(1, 17)
MOTORS_OF_TYPE = {2: 4, 13: 6, 14: 8, 15: 3, 29: 12, 35: 10}  # MAV_TYPE of multicopters
ARDUPILOT_FUNCTIONS = {*range(33, 41), *range(82, 86), 160, 161, 162, 163}  # of SERVOn_FUNCTION
PX4_FUNCTIONS = range(101, 113)  # of PWM_MAIN_FUNCn
FUNCTION_NAMES = ("SERVO{}_FUNCTION", "PWM_MAIN_FUNC{}")


def motor_outputs(flight: Flight) -> list[int]:
    """Return the numbers of the outputs that drive motors; none where nothing tells."""
    if flight.vehicle is None or flight.outing_kind.noun != FLIGHT.noun:
        return []
    values = read_parameters(flight).values
    functions = PX4_FUNCTIONS if flight.vehicle.autopilot == PX4 else ARDUPILOT_FUNCTIONS
    told = {
        number: values[name.format(number)]
        for name in FUNCTION_NAMES
        for number in OUTPUTS
        if name.format(number) in values
    }
    if told:
        return [number for number, function in told.items() if function in functions]
    return list(range(1, MOTORS_OF_TYPE.get(flight.vehicle.type, 0) + 1))
