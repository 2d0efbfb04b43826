"""The options of a vehicle that another simulator moves, and which of the others it cannot have."""

import argparse
from dataclasses import dataclass
from typing import Literal

from sitl.errors import UsageError
from sitl.process.options import values
from sitl.process.options.values import LOOPBACK, Address
from sitl.records.conditions import Conditions, EstimateErrors, Wind

SIH_PORT = 19410  # where PX4's SIH tells its true pose; grows with the instance
EXAMPLE = f"udpin:{LOOPBACK}:{SIH_PORT}"
Kind = Literal["udpin", "udpout"]  # it sends to us; we send first
Connection = tuple[Kind, Address]  # where we wait, or where it is

ITS_SIMULATORS_OWN = (  # options as given, and what the other simulator does instead
    ("hil_port", "--hil-port", "no PX4 connects to us; its simulator's link is named by --connect"),
    ("lockstep", "--lockstep", "its simulator runs by its own clock"),
    ("speed_factor", "--speed-factor", "its simulator has its own pace"),
    ("gcs_link", "--gcs-link", "the vehicle has its own links"),
    ("udp", "--udp", "the vehicle has its own links"),
    ("tcp", "--tcp", "the vehicle has its own links"),
    ("signing_key", "--signing-key", "the vehicle signs for itself"),
    ("files", "--files", "the vehicle keeps its own"),
    ("params", "--params", "the vehicle keeps its own"),
    ("perfect_estimate", "--perfect-estimate", "the vehicle estimates for itself"),
    ("ready_after", "--ready-after", "the vehicle is ready when it says so"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ExternalOptions:
    """How a vehicle that another simulator moves is met."""

    kind: Kind
    address: Address
    has_relay: bool  # its companion's link goes through us


def connection(text: str) -> Connection:
    """Read udpin:[HOST:]PORT or udpout:HOST:PORT."""
    kind, colon, rest = text.partition(":")
    if colon and kind == "udpin":
        return "udpin", values.listening_address(rest)
    if colon and kind == "udpout":
        return "udpout", values.address(rest)
    raise argparse.ArgumentTypeError(f"must be like {EXAMPLE} or udpout:HOST:PORT, got '{text}'")


def read_external(given: argparse.Namespace, conditions: Conditions) -> ExternalOptions:
    """Read them.

    Raises:
        UsageError: another option or condition is the other simulator's; says which.

    """
    for name, option, instead in ITS_SIMULATORS_OWN:
        if getattr(given, name):
            raise UsageError(f"{option}: not with --autopilot external; {instead}")
    for name, part, fine in (
        ("wind", conditions.wind, Wind()),
        ("estimate", conditions.estimate, EstimateErrors()),
    ):
        if part != fine:
            raise UsageError(
                f"--condition {name}: not with --autopilot external; its own simulator makes that"
            )
    connect: Connection = given.connect or ("udpin", (LOOPBACK, SIH_PORT + given.instance))
    kind, address = connect
    return ExternalOptions(kind=kind, address=address, has_relay=given.api_link is not None)
