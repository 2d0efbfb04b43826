"""Find, check and load a model that flies by a belief: a detector of gates, and how it is flown.

Its folder lies beside the others and holds the same files; its config.toml has a table [detector]
where theirs have [perception] and [policy].
"""

from dataclasses import dataclass
from pathlib import Path

from flightstack import models
from flightstack.errors import ModelError
from flightstack.perception.gate_decoding import DetectionCalibration
from flightstack.perception.gate_detector import GateDetector
from flightstack.tables import read_toml, record_from_table


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorFlightForm:
    """The hash of a detector's graph; empty where it has not been exported."""

    detector_sha256: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class GateModelConfig:
    """What config.toml says."""

    name: str
    recipe: str
    strategy: str  # used where the user names none
    weights_sha256: str
    speed_m_s: float  # along a gate's axis, when aligned
    flight: DetectorFlightForm = DetectorFlightForm()
    detector: DetectionCalibration

    def __post_init__(self) -> None:
        """Refuse a speed that nobody means."""
        if not 0.0 < self.speed_m_s <= models.MAX_SPEED_M_S:
            raise ValueError(f"speed_m_s must be above 0, up to {models.MAX_SPEED_M_S:g}")


@dataclass(frozen=True, slots=True, kw_only=True)
class GateModel:
    """A detector, ready, and how it is flown."""

    config: GateModelConfig
    detector: GateDetector


def is_gate_model(name: str) -> bool:
    """Whether a model has a detector; raises ModelError for one that is unknown."""
    return "detector" in _table(models.find(name) / models.CONFIG_FILE)


def load_gate_model(name: str) -> GateModel:
    """Load a model; raises ModelError where it is unknown, damaged, or no detector."""
    folder = models.find(name)
    config = read_gate_config(folder)
    sha256 = config.flight.detector_sha256
    if not sha256:
        raise models.unexported(name)
    return GateModel(config=config, detector=GateDetector(folder, config.detector, sha256=sha256))


def read_gate_config(folder: Path) -> GateModelConfig:
    """Read and check a folder's config.toml; raises ModelError."""
    path = folder / models.CONFIG_FILE
    try:
        return record_from_table(GateModelConfig, _table(path), where=str(path))
    except ValueError as error:
        raise ModelError(str(error)) from error


def _table(path: Path) -> dict[str, object]:
    try:
        with path.open("rb") as file:
            return read_toml(file.read(models.MAX_CONFIG_BYTES).decode(), where=str(path))
    except (OSError, ValueError) as error:
        raise ModelError(f"{path}: {error}") from error
