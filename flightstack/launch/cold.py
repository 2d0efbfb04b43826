"""Start each flight's processes anew, as a user does in two or three terminals."""

import contextlib
from typing import IO

from flightstack.launch.order import COMPANION, VEHICLE, Ended, Order
from flightstack.launch.processes import programs, started
from flightstack.launch.px4 import prepared_px4


class ColdStarter:
    """A `Starter` that keeps nothing."""

    def prepare(self) -> None:
        """Do nothing."""

    def fly(self, order: Order) -> Ended:
        """Fly until the companion has ended, or the vehicle has refused to start."""
        with contextlib.ExitStack() as stack:

            def into(name: str) -> IO[bytes]:
                return stack.enter_context((order.folder / name).open("wb"))

            both = programs(
                order.request,
                order.ports,
                vehicle=(into(f"{VEHICLE}.out"), into(f"{VEHICLE}.err")),
                companion=(into(f"{COMPANION}.out"), into(f"{COMPANION}.err")),
            )
            px4 = stack.enter_context(prepared_px4(order.request, order.ports))
            pair = stack.enter_context(started(*both, None if px4 is None else px4.program))
            pair.wait(order.limit_s)
            died = None if px4 is None else px4.explain_end(pair)
            codes = pair.vehicle.poll(), pair.companion.poll()
        return Ended(vehicle=codes[0], companion=codes[1], folder=order.folder, px4=died)

    def close(self) -> None:
        """Do nothing."""
