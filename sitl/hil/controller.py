"""A real PX4 as the flight controller: sensors go out at a tick's end, motors come for the next.

In lockstep each tick waits for PX4's answer to the last one; where none comes it goes on:

    answering --no answer within PATIENCE_S--> silent
        ^                                        |
        `---------any motor command--------------'

PX4 sends none while it boots, nor in OFFBOARD while it is disarmed and hears no setpoints. Silent,
ticks pass in real time. Armed it always answers, so a silent PX4 then is stopped or overloaded:
the first ticks wait for a second each, and so for five seconds the vehicle hardly moves.
"""

import logging
import time
from collections.abc import Callable

from sitl.clock import SECOND_US, TICK_S, Schedule
from sitl.frames import geodetic_from_ned
from sitl.hil.connection import Px4Connection
from sitl.hil.messages import BAROMETER, INERTIAL, MAGNETOMETER, NO_THRUST, hil_gps, hil_sensor
from sitl.mavlink.streams.motion import true_state
from sitl.mavlink.wire.dialect import Message
from sitl.mavlink.wire.packets import pack, wrap
from sitl.records.failures import Failure
from sitl.records.motion import MotorThrusts, Vector3, VehicleState
from sitl.records.sensing import Readings
from sitl.sensors.battery import Pack
from sitl.sensors.suite import PACK

SYSTEM, COMPONENT = 1, 200  # PX4 looks at neither; Gazebo classic sends as these
TRUTH_HZ = 50  # PX4 asks for 200, and keeps it for its log alone
PATIENCE_S = 0.1  # wall time, disarmed: answers take 0.4 ms, on a machine that others use 20
ARMED_PATIENCE_S = 1.0
ARMED_PATIENT_TICKS = 5

_log = logging.getLogger(__name__)


class HilController:
    """Speaks PX4's simulator interface over a connection that comes and goes."""

    def __init__(
        self,
        connection: Px4Connection,
        *,
        home: Vector3,
        unix_epoch_us: int = 0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`home` is the origin of the local frame, `clock` the wall clock in seconds."""
        self._connection = connection
        self._home = home
        self._unix_epoch_us = unix_epoch_us
        self._clock = clock
        self._sequence = 0
        self._truth = Schedule(TRUTH_HZ)
        self._served = 0  # which of the connections is flown
        self._sent_us = self._answered_us = 0
        self._unanswered = 0  # ticks in a row
        self._is_silent = True
        self._motors = NO_THRUST
        self._last: Readings | None = None
        self.armed = False
        self.pack: Pack = PACK  # not PX4's, which simulates its own

    def sense(self, state: VehicleState, readings: Readings) -> None:
        """Send what the sensors read; HIL_SENSOR last, since it moves PX4's clock."""
        connection = self._connection
        if connection.connections != self._served or not connection.is_connected:
            self._begin()
        if not connection.is_connected or state.time_us == 0:  # PX4 takes a time of 0 for none
            return
        data = b""
        if self._truth.due(state.time_us):
            place = geodetic_from_ned(state.position_ned, self._home)
            data += self._packet(true_state(state.time_us, state, place))
        last, self._last = self._last, readings
        if last is None or readings.gps.time_us != last.gps.time_us:
            unix_us = self._unix_epoch_us + state.time_us
            data += self._packet(hil_gps(readings.gps, self._home, unix_us))
        groups = INERTIAL
        if last is None or readings.field_frd != last.field_frd:
            groups |= MAGNETOMETER
        if last is None or readings.pressure_hpa != last.pressure_hpa:
            groups |= BAROMETER
        data += self._packet(hil_sensor(state.time_us, readings, groups))
        connection.send(data)
        self._sent_us = state.time_us

    def drive(self) -> MotorThrusts:
        """Give the motors that answer the last sensors, or those before where no answer comes."""
        if self._connection.is_connected and self._sent_us > self._answered_us:
            self._await_answer()
        if not self._connection.is_connected:
            self._begin()
        return self._motors

    def drain_failures(self) -> list[Failure]:
        """Nothing: PX4 simulates the failures of its sensors itself."""
        return []

    def _begin(self) -> None:
        """Begin with another PX4, or none: its motors stand."""
        self._served = self._connection.connections
        self._sent_us = self._answered_us = self._unanswered = 0
        self._is_silent = True
        self._motors, self.armed = NO_THRUST, False
        self._last = None

    def _await_answer(self) -> None:
        deadline_s = self._clock() + self._patience_s()
        self._take()
        while self._answered_us < self._sent_us and self._connection.is_connected:
            left_s = deadline_s - self._clock()
            if left_s <= 0.0:
                self._note_silence()
                return
            self._connection.serve(left_s)
            self._take()
        self._unanswered = 0

    def _take(self) -> None:
        command = self._connection.take_motors()
        if command is None:
            return
        self._motors, self.armed = command.thrusts, command.armed
        self._answered_us = command.time_us
        if self._is_silent and self._unanswered:
            _log.debug("PX4 answers again at %.3f s", self._sent_us / SECOND_US)
        self._is_silent = False

    def _patience_s(self) -> float:
        if self.armed and self._unanswered < ARMED_PATIENT_TICKS:
            return ARMED_PATIENCE_S
        return TICK_S if self._is_silent else PATIENCE_S

    def _note_silence(self) -> None:
        self._unanswered += 1
        if self.armed and self._unanswered in (1, ARMED_PATIENT_TICKS):
            _log.warning(
                "waiting for PX4's motor commands: none for %d s%s",
                self._unanswered,
                "" if self._unanswered == 1 else "; going on without, in real time",
            )
        self._is_silent = not self.armed or self._unanswered >= ARMED_PATIENT_TICKS

    def _packet(self, message: Message) -> bytes:
        self._sequence = (self._sequence + 1) & 0xFF
        return wrap(pack(message), sequence=self._sequence, system=SYSTEM, component=COMPONENT)
