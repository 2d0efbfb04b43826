"""The commander: who is in charge of what the vehicle does; arming, modes, failsafe, disarming.

What the user intends and what is flown differ only in a failsafe:

    intended --failsafe.decide--> mode;  disarmed: mode = intended, whatever it is

The state is one frozen record, which only the commander replaces. What happened to it is queued as
transitions, each of which begins the mode anew.
"""

from enum import Enum
from typing import NamedTuple, Self

from sitl.autopilot.command.checks import Health, can_arm, can_run
from sitl.autopilot.command.failsafe import (
    FailsafeCause,
    FailsafeDecision,
    FailsafeInputs,
    FailsafeMemory,
    FailsafeParameters,
    decide,
    override,
)
from sitl.autopilot.command.health_watch import HealthWatch
from sitl.autopilot.command.mode_table import MODES, Action
from sitl.autopilot.flight_modes.navigator import Goal
from sitl.autopilot.parameters import ParameterValues
from sitl.clock import SECOND_US
from sitl.records.modes import Mode
from sitl.records.texts import CRITICAL, INFO, StatusText

FOLLOWING = {
    Action.RETURN: "Return",
    Action.LAND: "Land",
    Action.DISARM: "Disarm",
    Action.TERMINATE: "Flight termination",
}
CALM = FailsafeMemory()
NO_GOAL = Goal()


class CommanderParameters(NamedTuple):
    """When to disarm, and what a failsafe does."""

    disarm_landed_us: int  # COM_DISARM_LAND; not above 0: never
    disarm_preflight_us: int  # COM_DISARM_PRFLT; likewise
    failsafe: FailsafeParameters

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            disarm_landed_us=round(values["COM_DISARM_LAND"] * SECOND_US),
            disarm_preflight_us=round(values["COM_DISARM_PRFLT"] * SECOND_US),
            failsafe=FailsafeParameters.resolve(values),
        )


class CommanderState(NamedTuple):
    """What is commanded."""

    armed: bool = False
    intended: Mode = Mode.HOLD  # as the user chose
    mode: Mode = Mode.HOLD  # that is flown
    goal: Goal = NO_GOAL
    cause: FailsafeCause | None = None  # of a failsafe, while there is one
    memory: FailsafeMemory = CALM
    after_disarming: Mode = Mode.HOLD  # the last mode chosen that could be armed
    landed: bool = True  # as last detected
    has_flown: bool = False  # since arming
    since_us: int = 0  # arming, take-off or landing, whichever was last

    @property
    def failsafe(self) -> bool:
        """Whether a failsafe chooses the mode."""
        return self.cause is not None


class ModeTransition(Enum):
    """What happened to the state; with each of them the mode begins, perhaps again."""

    ARMED = 1
    DISARMED = 2
    SWITCHED = 3


class Commander:
    """Keeps the armed state, the intended mode and the mode that is flown."""

    def __init__(self, parameters: CommanderParameters, health_watch: HealthWatch) -> None:
        self.parameters = parameters
        self.state = CommanderState()
        self.rules = MODES[self.state.mode]  # of the mode that is flown
        self.transitions: tuple[ModeTransition, ...] = ()  # since they were last taken
        self._health_watch = health_watch
        self._fine_with: tuple[Health, CommanderParameters] | None = None
        self._is_ready = False  # to take off, as was said
        self._time_us = 0
        self._texts: list[StatusText] = []

    @property
    def health(self) -> Health:
        """What the checks look at now."""
        return self._health_watch.health

    def say(self, severity: int, text: str) -> None:
        """Tell the pilot; PX4's texts end in a tab."""
        self._texts.append(StatusText(severity=severity, text=text + "\t"))

    def drain_texts(self) -> list[StatusText]:
        """Take the texts that came up since the last call."""
        texts, self._texts = self._texts, []
        return texts

    def take_transitions(self) -> tuple[ModeTransition, ...]:
        """Take what happened to the state since the last call."""
        transitions, self.transitions = self.transitions, ()
        return transitions

    def start_airborne(self) -> None:
        """Begin in flight, in OFFBOARD."""
        self._is_ready = True
        state = CommanderState(
            armed=True,
            intended=Mode.OFFBOARD,
            mode=Mode.OFFBOARD,
            after_disarming=Mode.OFFBOARD,
            landed=False,
            has_flown=True,
        )
        self._become(state, ModeTransition.SWITCHED)

    def update(self, time_us: int, *, landed: bool) -> None:
        """Advance to `time_us`: failsafe, landing, automatic disarming."""
        self._time_us = time_us
        if not self._is_ready and can_arm(Mode.HOLD, self.health):
            self._is_ready = True
            self.say(INFO, "Ready for takeoff!")
        if not self.state.armed:
            if landed is not self.state.landed:
                self.state = self.state._replace(landed=landed)
            return
        self._decide()
        if not self.state.armed:
            return
        if landed is not self.state.landed:
            self.state = self.state._replace(landed=landed, since_us=time_us, has_flown=True)
            self.say(INFO, "Landing detected" if landed else "Takeoff detected")
        if landed:
            self._disarm_when_idle(time_us - self.state.since_us)

    def arm(self, text: str = "Armed by external command") -> bool:
        """Arm if the checks pass, and say so."""
        state = self.state
        if state.armed:
            return True
        if not can_arm(state.intended, self.health):
            self.say(CRITICAL, "Arming denied: Resolve system health failures first")
            return False
        armed = state._replace(
            armed=True,
            has_flown=False,
            landed=True,
            since_us=self._time_us,
            after_disarming=state.intended,
        )
        self._become(armed, ModeTransition.ARMED)
        self.say(INFO, text)
        return True

    def disarm(self, *, force: bool) -> bool:
        """Disarm on the ground, or anywhere if forced."""
        if not self.state.armed:
            return True
        if not (self.state.landed or force):
            self.say(CRITICAL, "Disarming denied: not landed")
            return False
        self._disarm("Disarmed by external command")
        return True

    def switch(self, mode: Mode, goal: Goal | None = None) -> bool:
        """Intend a mode and lead it to a goal; refused in flight if it can't run.

        A termination is a command of its own, no mode to choose, and none is left for another. A
        mode that is chosen takes over from a failsafe.
        """
        state, rules = self.state, MODES[mode]
        final = rules.is_final or self.rules.is_final
        if final or (state.armed and not can_run(mode, self.health)):
            self.say(CRITICAL, f"Switching to {rules.name} is currently not available")
            return False
        happened: tuple[ModeTransition, ...] = ()
        if mode is not state.intended or goal is not None or state.failsafe:
            happened = (ModeTransition.SWITCHED,)
            state = state._replace(goal=goal or NO_GOAL)
        if state.failsafe:
            state = state._replace(memory=override(self._failsafe_inputs(), state.memory))
        if rules.armable and (self.health.offboard_available or not rules.needs.setpoints):
            state = state._replace(after_disarming=mode)
        state = state._replace(intended=mode, mode=state.mode if state.armed else mode)
        self._become(state, *happened)
        if state.armed:
            self._decide()
        return True

    def terminate(self) -> None:
        """Stop the rotors for good, as in PX4: until the next boot."""
        self._become(self.state._replace(intended=Mode.TERMINATION, mode=Mode.TERMINATION))
        self.say(CRITICAL, "Flight termination active")

    def continue_as_hold(self) -> None:
        """Hold where the take-off leads: the motion goes on, no mode begins anew."""
        hold = Mode.HOLD
        self._become(self.state._replace(intended=hold, mode=hold, after_disarming=hold))

    def _become(self, state: CommanderState, *happened: ModeTransition) -> None:
        """Change mode or arming."""
        self.state, self.rules = state, MODES[state.mode]
        self.transitions += happened

    def _decide(self) -> None:
        """Let the failsafe table choose the mode, and say so when it takes over."""
        state, judged_by = self.state, (self._health_watch.health, self.parameters)
        if state.intended is state.mode and judged_by == self._fine_with:
            return  # nothing has changed since all was well
        if self.rules.is_final:
            return
        decision, memory = decide(self._failsafe_inputs(), state.memory, self._time_us)
        is_fine = decision.cause is None and memory == CALM
        self._fine_with = judged_by if is_fine else None
        if decision.cause is not state.cause:
            self._tell_of(decision)
        self.state = state._replace(cause=decision.cause, memory=memory)
        if decision.mode is None:
            self._disarm("Disarmed by failsafe")
        elif MODES[decision.mode].is_final:
            self.terminate()
        elif decision.mode is not state.mode:
            self._become(self.state._replace(mode=decision.mode), ModeTransition.SWITCHED)

    def _failsafe_inputs(self) -> FailsafeInputs:
        state = self.state
        return FailsafeInputs(state.armed, state.intended, self.health, self.parameters.failsafe)

    def _tell_of(self, decision: FailsafeDecision) -> None:
        """Say that a failsafe begins, and why where it isn't plain."""
        cause, following = decision.cause, decision.next_action
        if cause is None:
            return
        seconds = self.parameters.failsafe.hold_us / SECOND_US
        if not self.state.failsafe:
            held = "" if following is None else f": entering Hold for {seconds:.0f} seconds"
            self.say(CRITICAL, "Failsafe activated" + held)
        if following is not None:
            self.say(CRITICAL, f"{cause.value}: {FOLLOWING[following]} in {seconds:.0f} s")
        elif cause is not FailsafeCause.SETPOINTS:
            self.say(CRITICAL, cause.value)

    def _disarm_when_idle(self, idle_us: int) -> None:
        landed_us, preflight_us = self.parameters[:2]
        if self.state.has_flown and 0 < landed_us <= idle_us:
            self._disarm("Disarmed by landing")
        elif not self.state.has_flown and 0 < preflight_us <= idle_us:
            self._disarm("Disarmed by auto preflight disarming")

    def _disarm(self, text: str) -> None:
        """Stop, and fall back to the mode that the user last chose and that could be armed."""
        state = self.state
        mode = state.mode if self.rules.is_final else state.after_disarming
        disarmed = state._replace(
            armed=False,
            intended=mode,
            mode=mode,
            goal=NO_GOAL,
            cause=None,
            memory=CALM,
            landed=True,
        )
        self._become(disarmed, ModeTransition.DISARMED)
        self.say(INFO, text)
