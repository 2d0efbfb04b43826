"""Read an airframe's physical constants from its TOML file."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from sitl.errors import UsageError
from sitl.frames import GRAVITY_M_S2
from sitl.records.motion import Vector3

ROTORS = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Airframe:
    """A quadrotor's body and rotors; the file says where each figure comes from."""

    name: str
    mass_kg: float
    inertia_kg_m2: Vector3  # about the FRD axes
    collision_box_m: Vector3  # full lengths along the FRD axes
    rotor_positions_frd_m: tuple[tuple[float, float], ...]  # (4, 2) x, y
    rotor_directions: tuple[float, ...]  # (4,) +1 counterclockwise from above, -1 clockwise
    thrust_coefficient_n_s2: float
    moment_coefficient_m: float
    rotor_max_speed_rad_s: float
    rotor_time_constant_up_s: float
    rotor_time_constant_down_s: float
    rotor_drag_n_s2_m: float
    linear_drag_n_s_m: Vector3  # along the FRD axes
    angular_drag_n_m_s: Vector3  # about the FRD axes
    parameters: Mapping[str, float]  # autopilot defaults that this airframe changes

    @property
    def max_thrust_n(self) -> float:
        """Thrust of one rotor at its maximum speed."""
        return self.thrust_coefficient_n_s2 * self.rotor_max_speed_rad_s**2

    @property
    def rotor_yaw_moments_m(self) -> tuple[float, ...]:
        """Yaw moment (FRD, positive to the right) that each rotor gives per thrust."""
        return tuple(d * self.moment_coefficient_m for d in self.rotor_directions)

    @property
    def hover_thrust(self) -> float:
        """Fraction of the maximum thrust that carries the weight."""
        return self.mass_kg * GRAVITY_M_S2 / (ROTORS * self.max_thrust_n)


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
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"airframe {name}: not TOML: {error}") from error
    body = _Table(name, "", table)
    rotors = _Table(name, "rotors.", body.take("rotors", dict))
    drag = _Table(name, "drag.", body.take("drag", dict))
    airframe = Airframe(
        name=name,
        mass_kg=body.positive("mass_kg"),
        inertia_kg_m2=body.positive3("inertia_kg_m2"),
        collision_box_m=body.positive3("collision_box_m"),
        rotor_positions_frd_m=rotors.positions("positions_frd_m"),
        rotor_directions=rotors.directions("directions"),
        thrust_coefficient_n_s2=rotors.positive("thrust_coefficient_n_s2"),
        moment_coefficient_m=rotors.positive("moment_coefficient_m"),
        rotor_max_speed_rad_s=rotors.positive("max_speed_rad_s"),
        rotor_time_constant_up_s=rotors.positive("time_constant_up_s"),
        rotor_time_constant_down_s=rotors.positive("time_constant_down_s"),
        rotor_drag_n_s2_m=rotors.not_negative("drag_coefficient_n_s2_m"),
        linear_drag_n_s_m=drag.vector3("linear_n_s_m"),
        angular_drag_n_m_s=drag.vector3("angular_n_m_s"),
        parameters=body.take("parameters", dict),
    )
    for part in (body, rotors, drag):
        part.refuse_leftovers()
    if airframe.hover_thrust >= 1.0:
        excess = airframe.hover_thrust
        raise UsageError(f"airframe {name}: too weak, hover takes {excess:.2f} of its thrust")
    return airframe


class _Table:
    """One TOML table that is emptied key by key, so that what is left over is unknown."""

    def __init__(self, airframe: str, prefix: str, table: dict[str, Any]) -> None:
        self._where = f"airframe {airframe}: {prefix}"
        self._table = dict(table)

    def take(self, key: str, kind: type) -> Any:
        """Remove and return a value of the given type."""
        if key not in self._table:
            raise UsageError(f"{self._where}{key}: missing")
        value = self._table.pop(key)
        if not isinstance(value, kind):
            raise UsageError(f"{self._where}{key}: expected {kind.__name__}, got {value!r}")
        return value

    def positive(self, key: str) -> float:
        return self._number(key, self.take(key, object), above_zero=True)

    def not_negative(self, key: str) -> float:
        return self._number(key, self.take(key, object), above_zero=False)

    def positive3(self, key: str) -> Vector3:
        return self._vector3(key, above_zero=True)

    def vector3(self, key: str) -> Vector3:
        return self._vector3(key, above_zero=False)

    def positions(self, key: str) -> tuple[tuple[float, float], ...]:
        rows = self.take(key, list)
        if len(rows) != ROTORS or any(not isinstance(r, list) or len(r) != 2 for r in rows):
            raise UsageError(f"{self._where}{key}: expected {ROTORS} pairs, got {rows!r}")
        return tuple((float(x), float(y)) for x, y in rows)

    def directions(self, key: str) -> tuple[float, ...]:
        values = self.take(key, list)
        if sorted(values) != [-1, -1, 1, 1]:
            raise UsageError(f"{self._where}{key}: expected two 1 and two -1, got {values!r}")
        return tuple(float(value) for value in values)

    def refuse_leftovers(self) -> None:
        for key in self._table:
            raise UsageError(f"{self._where}{key}: unknown key")

    def _vector3(self, key: str, *, above_zero: bool) -> Vector3:
        values = self.take(key, list)
        if len(values) != 3:
            raise UsageError(f"{self._where}{key}: expected 3 numbers, got {values!r}")
        x, y, z = (self._number(key, value, above_zero=above_zero) for value in values)
        return (x, y, z)

    def _number(self, key: str, value: object, *, above_zero: bool) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UsageError(f"{self._where}{key}: expected a number, got {value!r}")
        if value < 0 or (above_zero and value == 0):
            sign = "positive" if above_zero else "0 or more"
            raise UsageError(f"{self._where}{key}: must be {sign}, got {value}")
        return float(value)
