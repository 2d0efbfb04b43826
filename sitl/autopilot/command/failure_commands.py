"""Take MAV_CMD_INJECT_FAILURE: refused unless SYS_FAILURE_EN allows it."""

from collections.abc import Callable, Mapping

from sitl.autopilot.command.commander import Commander
from sitl.autopilot.parameters import Parameters
from sitl.records.failures import Failure, parse_failure
from sitl.records.vehicle import Command

INJECT_FAILURE = 420  # MAV_CMD
ACCEPTED, DENIED, UNSUPPORTED = 0, 2, 3  # MAV_RESULT
WARNING = 4  # MAV_SEVERITY


class FailureCommands:
    """Keeps what is to fail until the simulation takes it."""

    def __init__(self, parameters: Parameters, commander: Commander) -> None:
        self._parameters = parameters  # asked at each command, not at the next tick
        self._commander = commander
        self._requests: list[Failure] = []
        self.handlers: Mapping[int, Callable[[Command], int]] = {INJECT_FAILURE: self._inject}

    def drain(self) -> list[Failure]:
        """Take what came in since the last call."""
        requests, self._requests = self._requests, []
        return requests

    def _inject(self, command: Command) -> int:
        if not self._parameters["SYS_FAILURE_EN"]:
            return DENIED
        failure = parse_failure(*command.params[:3])
        if failure is None:
            return UNSUPPORTED
        self._requests.append(failure)
        self._commander.say(WARNING, f"Failure injected: {failure.unit.name} {failure.type.name}")
        return ACCEPTED
