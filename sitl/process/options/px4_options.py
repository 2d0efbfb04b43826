"""Who flies: the options of a real PX4, and which of the others are the emulated one's alone."""

import argparse
from dataclasses import dataclass

from sitl.errors import UsageError
from sitl.process.options import values
from sitl.process.options.external_options import EXAMPLE, connection
from sitl.process.options.values import LOOPBACK, Address

HIL_PORT = 4560  # PX4's simulator interface; grows with the instance
PX4 = "px4"
EMULATED = "emulated"
EXTERNAL = "external"
EMULATED_ALONE = (  # options as given, and what PX4 does instead
    ("gcs_link", "--gcs-link", "PX4 has its own link to ground stations"),
    ("udp", "--udp", "PX4 opens its own links: `mavlink start` in its shell"),
    ("tcp", "--tcp", "PX4 opens its own links: `mavlink start` in its shell"),
    ("signing_key", "--signing-key", "PX4 signs for itself, from 1.18 on"),
    ("files", "--files", "PX4 keeps its files in the folder that it was started in"),
    ("params", "--params", "PX4 keeps its parameters in the folder that it was started in"),
    ("perfect_estimate", "--perfect-estimate", "PX4 estimates for itself"),
    ("ready_after", "--ready-after", "PX4 is ready when it says so"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Px4Options:
    """How a real PX4 is met."""

    hil_address: Address  # where we wait for it
    has_relay: bool  # its companion's link goes through us


def add_px4(parser: argparse.ArgumentParser) -> None:
    """Add what chooses and meets a real PX4."""
    group = parser.add_argument_group("who flies", "a real PX4, or another: docs/real-px4.md")
    group.add_argument(
        "--autopilot",
        choices=(EMULATED, PX4, EXTERNAL),
        default=EMULATED,
        help="px4: be the simulator of a PX4 that connects here; external: only look, from where "
        "a vehicle tells that it is. Its companion's link is relayed where --api-link names the "
        "companion's ports",
    )
    group.add_argument(
        "--connect",
        type=connection,
        metavar="LINK",
        help=f"where an external vehicle tells its pose, as {EXAMPLE} (the default: PX4's SIH, "
        "whose port grows with N) or udpout:HOST:PORT",
    )
    group.add_argument(
        "--hil-port",
        type=values.listening_address,
        metavar="[HOST:]PORT",
        help="where PX4 connects (TCP, default 4560 + N)",
    )
    group.add_argument(
        "--px4-environment",
        action="store_true",
        help="print what PX4 needs to know of the airframe, NAME=VALUE, and end",
    )


def read_px4(given: argparse.Namespace) -> Px4Options | None:
    """Read them; None where another flies.

    Raises:
        UsageError: an option belongs to the other autopilot, or lacks another; says which.

    """
    if given.autopilot != EXTERNAL and given.connect is not None:
        raise UsageError("--connect: only with --autopilot external")
    if given.autopilot != PX4:
        if given.hil_port is not None:
            raise UsageError("--hil-port: only with --autopilot px4")
        return None
    for name, option, instead in EMULATED_ALONE:
        if getattr(given, name):
            raise UsageError(f"{option}: not with --autopilot px4; {instead}")
    if given.lockstep and given.api_link is None:
        raise UsageError(
            "--lockstep with --autopilot px4 needs the companion's answers: name its ports by "
            "--api-link LOCAL:REMOTE, or fly without, at a --speed-factor that it can follow"
        )
    if given.log is not None and given.api_link is None:
        raise UsageError("--log with --autopilot px4 needs --api-link: else nothing passes here")
    return Px4Options(
        hil_address=given.hil_port or (LOOPBACK, HIL_PORT + given.instance),
        has_relay=given.api_link is not None,
    )
