"""Read an airframe's physical constants from its TOML file."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files

from sitl.errors import UsageError
from sitl.frames import GRAVITY_M_S2
from sitl.records.motion import Vector3
from sitl.toml_records import NOT_NEGATIVE, POSITIVE, Limits, parse_toml, read_record

ROTORS = 4

Pair = tuple[float, float]

LIMITS: Mapping[str, Limits] = {
    **dict.fromkeys(("mass_kg", "inertia_kg_m2", "collision_box_m"), POSITIVE),
    **dict.fromkeys(("thrust_coefficient_n_s2", "moment_coefficient_m"), POSITIVE),
    **dict.fromkeys(("time_constant_up_s", "time_constant_down_s", "max_speed_rad_s"), POSITIVE),
    **dict.fromkeys(("drag_coefficient_n_s2_m", "linear_n_s_m", "angular_n_m_s"), NOT_NEGATIVE),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Rotors:
    """Four rotors, all alike but for their places and directions."""

    positions_frd_m: tuple[Pair, Pair, Pair, Pair]  # x, y
    directions: tuple[float, float, float, float]  # +1 counterclockwise from above, -1 clockwise
    thrust_coefficient_n_s2: float
    moment_coefficient_m: float
    max_speed_rad_s: float
    time_constant_up_s: float
    time_constant_down_s: float
    drag_coefficient_n_s2_m: float

    def __post_init__(self) -> None:
        """Refuse rotors whose moments don't cancel; raises UsageError."""
        if sorted(self.directions) != [-1.0, -1.0, 1.0, 1.0]:
            raise UsageError(f"directions: must be two 1 and two -1, got {self.directions}")

    @property
    def max_thrust_n(self) -> float:
        """Thrust of one rotor at its maximum speed."""
        return self.thrust_coefficient_n_s2 * self.max_speed_rad_s**2

    @property
    def yaw_moments_m(self) -> tuple[float, ...]:
        """Yaw moment (FRD, positive to the right) that each rotor gives per thrust."""
        return tuple(d * self.moment_coefficient_m for d in self.directions)


@dataclass(frozen=True, slots=True, kw_only=True)
class Drag:
    """Of the body, without its rotors."""

    linear_n_s_m: Vector3  # along the FRD axes
    angular_n_m_s: Vector3  # about the FRD axes


@dataclass(frozen=True, slots=True, kw_only=True)
class Airframe:
    """A quadrotor's body and rotors; the file says where each figure comes from."""

    mass_kg: float
    inertia_kg_m2: Vector3  # about the FRD axes
    collision_box_m: Vector3  # full lengths along the FRD axes
    rotors: Rotors
    drag: Drag
    parameters: Mapping[str, float]  # autopilot defaults that this airframe changes

    def __post_init__(self) -> None:
        """Refuse what cannot fly; raises UsageError."""
        if self.hover_thrust >= 1.0:
            raise UsageError(f"too weak, hover takes {self.hover_thrust:.2f} of its thrust")

    @property
    def hover_thrust(self) -> float:
        """Fraction of the maximum thrust that carries the weight."""
        return self.mass_kg * GRAVITY_M_S2 / (ROTORS * self.rotors.max_thrust_n)


def load_airframe(name: str) -> Airframe:
    """Load `airframes/<name>.toml`; raises UsageError with the file and the key that is wrong."""
    folder = files("sitl.world") / "airframes"
    file = folder / f"{name}.toml"
    if not file.is_file():
        known = ", ".join(sorted(f.name.removesuffix(".toml") for f in folder.iterdir()))
        raise UsageError(f"airframe '{name}': unknown; known are: {known}")
    return parse_airframe(name, file.read_text())


def parse_airframe(name: str, text: str) -> Airframe:
    """Build an airframe from TOML text; every key must be there, known and of the right sign."""
    where = f"airframe {name}"
    return read_record(Airframe, parse_toml(text, where), LIMITS, f"{where}: ")
