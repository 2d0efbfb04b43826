"""Start each flight's two processes anew, as a user does in two terminals."""

import contextlib
from typing import IO

from flightstack.launch.order import COMPANION, VEHICLE, Ended, Order
from flightstack.launch.processes import COMPANION_MODULE, VEHICLE_MODULE, Program, started


class ColdStarter:
    """A `Starter` that keeps nothing."""

    def prepare(self) -> None:
        """Do nothing."""

    def fly(self, order: Order) -> Ended:
        """Fly until the companion has ended, or the vehicle has refused to start."""
        with contextlib.ExitStack() as stack:

            def into(name: str) -> IO[bytes]:
                return stack.enter_context((order.folder / name).open("wb"))

            outputs = {
                name: (into(f"{name}.out"), into(f"{name}.err")) for name in (VEHICLE, COMPANION)
            }
            pair = stack.enter_context(
                started(
                    Program.module(VEHICLE_MODULE, order.vehicle, *outputs[VEHICLE]),
                    Program.module(COMPANION_MODULE, order.companion, *outputs[COMPANION]),
                )
            )
            pair.wait(order.limit_s)
            codes = pair.vehicle.poll(), pair.companion.poll()
        return Ended(vehicle=codes[0], companion=codes[1], folder=order.folder)

    def close(self) -> None:
        """Do nothing."""
