"""The autopilot's parameters: PX4's names, types, defaults and ranges, from `parameters.toml`.

`Parameters` is the store, which the wire writes. `Parameters.values` is a frozen table of them: a
change makes another one, so that its identity tells whether anything has changed. Nobody looks a
name up in the loop: what needs parameters declares a record of typed numbers in SI units, under
plain names, and resolves it once from such a table:

    class HeadingParameters(NamedTuple):
        rate_max_rad_s: float  # MPC_YAWRAUTO_MAX

        @classmethod
        def resolve(cls, values: ParameterValues) -> Self:
            return cls(rate_max_rad_s=math.radians(values["MPC_YAWRAUTO_MAX"]))

It takes its record in its constructor and keeps it as `parameters`; whoever owns it puts a newly
resolved one there after a change. What is made of parts has a record made of theirs.
"""

import math
import struct
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from importlib.resources import files
from types import MappingProxyType

from sitl.errors import UsageError

INT32_MIN, INT32_MAX = -(2**31), 2**31 - 1
SINGLE_MAX = 3.4028234e38

ParameterValues = Mapping[str, float]  # an int for INT32, a float of single precision else


class ParameterType(IntEnum):
    """MAV_PARAM_TYPE of the two types that PX4 has."""

    INT32 = 6
    REAL32 = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class Specification:
    """What one parameter may be."""

    name: str
    type: ParameterType
    default: float
    minimum: float
    maximum: float
    unit: str


class Parameters:
    """A typed, bounded table; `values` is another object after each change."""

    def __init__(self, overrides: Mapping[str, float] | None = None) -> None:
        self._specifications = _specifications()
        defaults = {name: spec.default for name, spec in self._specifications.items()}
        self.values: ParameterValues = MappingProxyType(defaults)
        for name, value in (overrides or {}).items():
            self.set(name, value)

    def __contains__(self, name: object) -> bool:
        return name in self.values

    def __getitem__(self, name: str) -> float:
        return self.values[name]

    def names(self) -> list[str]:
        """All names, sorted: their places are the wire's param_index."""
        return sorted(self.values)

    def get(self, name: str) -> float:
        """Give the value: an int for INT32, a float (of single precision) for REAL32."""
        self._require(name)
        return self.values[name]

    def specification(self, name: str) -> Specification:
        """Give the type, default, range and unit."""
        return self._require(name)

    def type_of(self, name: str) -> ParameterType:
        """Give the wire type."""
        return self._require(name).type

    def set(self, name: str, value: float) -> None:
        """Change a value; raises UsageError, and changes nothing, if it is not allowed."""
        spec = self._require(name)
        if not math.isfinite(value):
            raise UsageError(f"parameter {name}: must be finite, got {value}")
        if spec.type is ParameterType.INT32 and value != int(value):
            raise UsageError(f"parameter {name}: must be a whole number, got {value}")
        typed = int(value) if spec.type is ParameterType.INT32 else _single(value)
        if not spec.minimum <= typed <= spec.maximum:
            limits = f"{spec.minimum:g} to {spec.maximum:g} {spec.unit}".rstrip()
            raise UsageError(f"parameter {name}: must be {limits}, got {value:g}")
        if typed != self.values[name]:
            self.values = MappingProxyType({**self.values, name: typed})

    def set_from_text(self, name: str, text: str) -> None:
        """Change a value given as text, as an environment variable does; raises UsageError."""
        try:
            value = float(text)
        except ValueError:
            raise UsageError(f"parameter {name}: must be a number, got '{text}'") from None
        self.set(name, value)

    def _require(self, name: str) -> Specification:
        if name not in self._specifications:
            raise UsageError(f"parameter {name}: unknown")
        return self._specifications[name]


def _single(value: float) -> float:
    """Round to the single precision in which PX4 stores it."""
    return float(
        struct.unpack("<f", struct.pack("<f", max(-SINGLE_MAX, min(SINGLE_MAX, value))))[0]
    )


@cache
def _specifications() -> Mapping[str, Specification]:
    table = tomllib.loads((files("sitl.autopilot") / "parameters.toml").read_text())
    return {name: _specification(name, row) for name, row in table.items()}


def _specification(name: str, row: Mapping[str, float | str]) -> Specification:
    default = row["default"]
    is_int = isinstance(default, int)

    def limit(key: str, otherwise: float) -> float:
        return float(row.get(key, otherwise)) if is_int else _single(float(row.get(key, otherwise)))

    return Specification(
        name=name,
        type=ParameterType.INT32 if is_int else ParameterType.REAL32,
        default=int(default) if is_int else _single(float(default)),
        minimum=limit("min", INT32_MIN if is_int else -SINGLE_MAX),
        maximum=limit("max", INT32_MAX if is_int else SINGLE_MAX),
        unit=str(row.get("unit", "")),
    )
