"""The commander: who is in charge of what the vehicle does; arming, modes, failsafe, disarming.

What the user intends and what is flown differ only in a failsafe:

    intended --failsafe.decide--> mode;  disarmed: mode = intended, whatever it is
"""

from sitl.autopilot.command.checks import ARMABLE, NAMES, Health, can_arm, can_run
from sitl.autopilot.command.failsafe import (
    Action,
    Actions,
    Cause,
    Conditions,
    Decision,
    Memory,
    decide,
    override,
)
from sitl.autopilot.flight_modes.navigator import Goal
from sitl.autopilot.parameters import Parameters
from sitl.clock import SECOND_US
from sitl.records.modes import BASE_ARMED, BASE_ATTITUDE, Mode
from sitl.records.texts import CRITICAL, INFO, StatusText

FOLLOWING = {
    Action.RETURN: "Return",
    Action.LAND: "Land",
    Action.DISARM: "Disarm",
    Action.TERMINATE: "Flight termination",
}
CALM = Memory()
BOOT, STANDBY, ACTIVE, FAILSAFE, TERMINATED = 0, 3, 4, 5, 8  # MAV_STATE


class Commander:
    """Keeps the armed state, the intended mode and the mode that is flown."""

    def __init__(self, parameters: Parameters) -> None:
        self.armed = False
        self.intended = self.mode = Mode.HOLD
        self.failsafe = False
        self._cause: Cause | None = None  # of the failsafe
        self._memory = CALM
        self.goal = Goal()
        self.armings = 0
        self.entries = 0  # counts beginnings of a mode, so that one can begin again
        self.health = Health()
        self._after_disarming = Mode.HOLD
        self._landed = True
        self._has_flown = False  # since arming
        self._since_us = 0  # arming or landing, whichever was last
        self._ready = False
        self._time_us = 0
        self._texts: list[StatusText] = []
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take times and actions from the parameters."""
        p = parameters
        self._disarm_landed_us = round(p["COM_DISARM_LAND"] * SECOND_US)
        self._disarm_preflight_us = round(p["COM_DISARM_PRFLT"] * SECOND_US)
        self._fine_with: Health | None = None  # under which the mode intended is flown
        self._actions = Actions(
            int(p["COM_OBL_RC_ACT"]),
            int(p["NAV_DLL_ACT"]),
            int(p["COM_DLL_EXCEPT"]),
            int(p["NAV_RCL_ACT"]),
            int(p["COM_RCL_EXCEPT"]),
            int(p["COM_LOW_BAT_ACT"]),
            int(p["GF_ACTION"]),
            round(p["COM_FAIL_ACT_T"] * SECOND_US),
        )

    def say(self, severity: int, text: str) -> None:
        """Tell the pilot; PX4's texts end in a tab."""
        self._texts.append(StatusText(severity=severity, text=text + "\t"))

    def drain_texts(self) -> list[StatusText]:
        """Take the texts that came up since the last call."""
        texts, self._texts = self._texts, []
        return texts

    def start_airborne(self) -> None:
        """Begin in flight, in OFFBOARD."""
        self.armed, self._has_flown, self._landed, self._ready = True, True, False, True
        self.intended = self.mode = self._after_disarming = Mode.OFFBOARD
        self.failsafe = False
        self.health = Health(
            attitude_valid=True, position_valid=True, altitude_valid=True, offboard_available=True
        )
        self.entries += 1

    def update(self, time_us: int, health: Health, *, landed: bool) -> None:
        """Advance to `time_us`: failsafe, landing, automatic disarming."""
        self._time_us, self.health = time_us, health
        if not self._ready and can_arm(Mode.HOLD, health):
            self._ready = True
            self.say(INFO, "Ready for takeoff!")
        if not self.armed:
            self._landed = landed
            return
        self._decide()
        if not self.armed:
            return
        if landed is not self._landed:
            self._landed, self._since_us = landed, time_us
            self._has_flown = True
            self.say(INFO, "Landing detected" if landed else "Takeoff detected")
        if landed:
            self._disarm_when_idle(time_us - self._since_us)

    def arm(self, text: str = "Armed by external command") -> bool:
        """Arm if the checks pass, and say so."""
        if self.armed:
            return True
        if not can_arm(self.intended, self.health):
            self.say(CRITICAL, "Arming denied: Resolve system health failures first")
            return False
        self.armed, self._has_flown, self._landed = True, False, True
        self._since_us = self._time_us
        self._after_disarming = self.intended
        self.armings += 1
        self.entries += 1
        self.say(INFO, text)
        return True

    def disarm(self, *, force: bool) -> bool:
        """Disarm on the ground, or anywhere if forced."""
        if not self.armed:
            return True
        if not (self._landed or force):
            self.say(CRITICAL, "Disarming denied: not landed")
            return False
        self._disarm("Disarmed by external command")
        return True

    def switch(self, mode: Mode, goal: Goal | None = None) -> bool:
        """Intend a mode; refused in flight if it can't run.

        A termination is a command of its own, no mode to choose, and none is left for another.
        """
        final = self.is_terminated or mode is Mode.TERMINATION
        if final or (self.armed and not can_run(mode, self.health)):
            self.say(CRITICAL, f"Switching to {NAMES[mode]} is currently not available")
            return False
        self.begin(mode, goal)
        return True

    def begin(self, mode: Mode, goal: Goal | None = None) -> None:
        """Intend a mode, begin it, and lead it to a goal; it takes over from a failsafe."""
        if mode is not self.intended or goal is not None or self.failsafe:
            self.entries += 1
            self.goal = goal or Goal()
        if self.failsafe:
            self._memory = override(self._conditions(), self._memory)
        self.intended = mode
        if mode in ARMABLE and (mode is not Mode.OFFBOARD or self.health.offboard_available):
            self._after_disarming = mode
        if self.armed:
            self._decide()
        else:
            self.mode = mode

    @property
    def is_terminated(self) -> bool:
        """Whether the flight was terminated: that is for good, as in PX4, until the next boot."""
        return self.mode is Mode.TERMINATION

    def terminate(self) -> None:
        """Stop the rotors for good."""
        self.intended = self.mode = Mode.TERMINATION
        self.say(CRITICAL, "Flight termination active")

    def continue_as_hold(self) -> None:
        """Hold where the take-off leads: the motion goes on, no mode begins anew."""
        self.intended = self.mode = self._after_disarming = Mode.HOLD

    @property
    def landed(self) -> bool:
        """Whether the vehicle stands on the ground, as last detected."""
        return self._landed

    @property
    def base_mode(self) -> int:
        """HEARTBEAT.base_mode."""
        base = self.mode.base_mode | (BASE_ARMED if self.armed else 0)
        if self.mode is Mode.OFFBOARD and self.health.offboard_available:
            base |= BASE_ATTITUDE
        return base

    @property
    def system_status(self) -> int:
        """HEARTBEAT.system_status."""
        if not self.armed:
            return STANDBY if can_arm(self.intended, self.health) else BOOT
        if self.mode is Mode.TERMINATION:
            return TERMINATED
        return FAILSAFE if self.failsafe else ACTIVE

    def _decide(self) -> None:
        """Let the failsafe table choose the mode, and say so when it takes over."""
        if self.intended is Mode.TERMINATION:
            return
        if self.health is self._fine_with and self.intended is self.mode:
            return  # nothing has changed since all was well
        decision, self._memory = decide(self._conditions(), self._memory, self._time_us)
        is_fine = decision.cause is None and self._memory == CALM
        self._fine_with = self.health if is_fine else None
        if decision.cause is not self._cause:
            self._tell_of(decision)
        self.failsafe, self._cause = decision.cause is not None, decision.cause
        if decision.mode is None:
            self._disarm("Disarmed by failsafe")
        elif decision.mode is Mode.TERMINATION:
            self.terminate()
        elif decision.mode is not self.mode:
            self.mode = decision.mode
            self.entries += 1

    def _conditions(self) -> Conditions:
        return Conditions(self.armed, self.intended, self.health, self._actions)

    def _tell_of(self, decision: Decision) -> None:
        """Say that a failsafe begins, and why where it isn't plain."""
        cause, following = decision.cause, decision.next_action
        if cause is None:
            return
        if not self.failsafe:
            self.say(CRITICAL, "Failsafe activated")
        if following is not None:
            seconds = self._actions.hold_us / SECOND_US
            self.say(CRITICAL, f"{cause.value}: {FOLLOWING[following]} in {seconds:.0f} s")
        elif cause is not Cause.SETPOINTS:
            self.say(CRITICAL, cause.value)

    def _disarm_when_idle(self, idle_us: int) -> None:
        if self._has_flown and 0 < self._disarm_landed_us <= idle_us:
            self._disarm("Disarmed by landing")
        elif not self._has_flown and 0 < self._disarm_preflight_us <= idle_us:
            self._disarm("Disarmed by auto preflight disarming")

    def _disarm(self, text: str) -> None:
        """Stop, and fall back to the mode that the user last chose and that could be armed."""
        self.armed, self.failsafe, self._landed = False, False, True
        self._cause, self._memory = None, Memory()
        if not self.is_terminated:
            self.intended = self.mode = self._after_disarming
        self.goal = Goal()
        self.entries += 1
        self.say(INFO, text)
