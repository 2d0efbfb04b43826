"""What the autopilot says about itself, as the records that MAVLink sends."""

from sitl.autopilot.command.checks import can_arm
from sitl.autopilot.command.commander import Commander
from sitl.autopilot.control.cascade import Cascade
from sitl.records.modes import Mode
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.vehicle import SetpointEcho, VehicleStatus

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
DISARMED_US, IDLE_US, FULL_US = 900, 1000, 2000  # pulse widths of SERVO_OUTPUT_RAW
ON_GROUND, IN_AIR = 1, 2  # MAV_LANDED_STATE
AIRBORNE_STATES = {Mode.TAKEOFF: 3, Mode.LAND: 4}  # MAV_LANDED_STATE, where it isn't IN_AIR


def report_status(
    commander: Commander,
    cascade: Cascade,
    estimate: Estimate,
    *,
    home: Vector3,
    home_ned: Vector3 | None,
) -> VehicleStatus:
    """Sum up mode, arming, health and outputs."""
    return VehicleStatus(
        time_us=estimate.time_us,
        mode=commander.mode,
        intended_mode=commander.intended,
        custom_mode=commander.mode.custom_mode,
        base_mode=commander.base_mode,
        system_status=commander.system_status,
        armed=commander.armed,
        armable=can_arm(commander.intended, commander.health),
        failsafe=commander.failsafe,
        landed_state=_landed_state(commander),
        home=home,
        home_ned=home_ned or ORIGIN,
        home_valid=home_ned is not None,
        attitude_valid=estimate.attitude_valid,
        position_valid=estimate.position_valid,
        altitude_valid=estimate.altitude_valid,
        battery_warning=int(commander.health.battery),
        throttle=cascade.state.attitude.thrust,
        actuator_outputs=_outputs(cascade, armed=commander.armed),
    )


def report_setpoint(cascade: Cascade, time_us: int) -> SetpointEcho:
    """Sum up what each controller follows now."""
    setpoint, attitude, rates_frd, _, _ = cascade.state
    return SetpointEcho(
        time_us=time_us,
        position_ned=setpoint.position_ned,
        velocity_ned=attitude.velocity_ned,
        acceleration_ned=attitude.acceleration_ned,
        yaw_rad=attitude.yaw_rad,
        yaw_rate_rad_s=attitude.yaw_rate_rad_s,
        q_ned_frd=attitude.q_ned_frd,
        rates_frd=rates_frd,
        thrust=attitude.thrust,
    )


def _landed_state(commander: Commander) -> int:
    return ON_GROUND if commander.landed else AIRBORNE_STATES.get(commander.mode, IN_AIR)


def _outputs(cascade: Cascade, *, armed: bool) -> tuple[int, int, int, int]:
    if not armed:
        return (DISARMED_US, DISARMED_US, DISARMED_US, DISARMED_US)
    span = FULL_US - IDLE_US
    a, b, c, d = (IDLE_US + round(span * motor) for motor in cascade.state.motors)
    return (a, b, c, d)
