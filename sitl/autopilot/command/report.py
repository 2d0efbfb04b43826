"""What the autopilot says about itself, as the records that MAVLink sends."""

from sitl.autopilot.command.checks import can_arm
from sitl.autopilot.command.commander import Commander
from sitl.autopilot.control.cascade import Cascade
from sitl.records.modes import BASE_ARMED, BASE_ATTITUDE
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.vehicle import SetpointEcho, VehicleStatus

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
DISARMED_US, IDLE_US, FULL_US = 900, 1000, 2000  # pulse widths of SERVO_OUTPUT_RAW
ON_GROUND = 1  # MAV_LANDED_STATE
BOOT, STANDBY, ACTIVE, FAILSAFE, TERMINATED = 0, 3, 4, 5, 8  # MAV_STATE


def report_status(
    commander: Commander,
    cascade: Cascade,
    estimate: Estimate,
    *,
    home: Vector3,
    home_ned: Vector3 | None,
) -> VehicleStatus:
    """Sum up mode, arming, health and outputs."""
    state, rules, health = commander.state, commander.rules, commander.health
    armable = can_arm(state.intended, health)
    return VehicleStatus(
        time_us=estimate.time_us,
        mode=state.mode,
        intended_mode=state.intended,
        custom_mode=state.mode.custom_mode,
        base_mode=_base_mode(commander),
        system_status=_system_status(commander, armable=armable),
        armed=state.armed,
        armable=armable,
        failsafe=state.failsafe,
        landed_state=ON_GROUND if state.landed else rules.landed_state_in_air,
        home=home,
        home_ned=home_ned or ORIGIN,
        home_valid=home_ned is not None,
        attitude_valid=estimate.attitude_valid,
        position_valid=estimate.position_valid,
        altitude_valid=estimate.altitude_valid,
        battery_warning=int(health.battery),
        throttle=cascade.state.attitude.thrust,
        actuator_outputs=_outputs(cascade, armed=state.armed),
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


def _base_mode(commander: Commander) -> int:
    """HEARTBEAT.base_mode."""
    state = commander.state
    base = state.mode.base_mode | (BASE_ARMED if state.armed else 0)
    if commander.rules.needs.setpoints and commander.health.offboard_available:
        base |= BASE_ATTITUDE
    return base


def _system_status(commander: Commander, *, armable: bool) -> int:
    """HEARTBEAT.system_status."""
    if not commander.state.armed:
        return STANDBY if armable else BOOT
    if commander.rules.is_final:
        return TERMINATED
    return FAILSAFE if commander.state.failsafe else ACTIVE


def _outputs(cascade: Cascade, *, armed: bool) -> tuple[int, int, int, int]:
    if not armed:
        return (DISARMED_US, DISARMED_US, DISARMED_US, DISARMED_US)
    span = FULL_US - IDLE_US
    a, b, c, d = (IDLE_US + round(span * motor) for motor in cascade.state.motors)
    return (a, b, c, d)
