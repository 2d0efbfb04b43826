"""The gate detector, trained and ready: an image to a set of gates with uncertainties."""

from pathlib import Path

from flightstack.arrays import SmallRgb
from flightstack.inference.graph import Graph, Signature
from flightstack.perception.gate_decoding import CELLS, OUTPUTS, DetectionCalibration, decode
from flightstack.records import GateDetections

DETECTOR_FILE = "detector.onnx"
RGB, CELLS_OUT = "rgb", "cells"
DETECTOR_SIGNATURE = Signature(
    inputs={RGB: (1, 64, 64, 3)}, outputs={CELLS_OUT: (1, OUTPUTS, CELLS, CELLS)}
)


class GateDetector:
    """Detects gates, one image after another; a pure function of the image."""

    def __init__(self, folder: Path, calibration: DetectionCalibration, *, sha256: str) -> None:
        """Load it from a model's folder; raises ModelError."""
        self._graph = Graph(folder / DETECTOR_FILE, sha256=sha256, signature=DETECTOR_SIGNATURE)
        self._calibration = calibration

    def detect(self, rgb: SmallRgb) -> GateDetections:
        """Return the gates in an image of 64 x 64 pixels."""
        (cells,) = self._graph.run([CELLS_OUT], {RGB: rgb[None]})
        return decode(cells[0], self._calibration)
