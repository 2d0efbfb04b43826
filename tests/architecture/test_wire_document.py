"""The document of the wire tells the rates and the messages that the code has."""

import re
from pathlib import Path

from sitl.mavlink.dialect import mavlink
from sitl.mavlink.encoders import ENCODERS
from sitl.mavlink.streams import GROUND_STATION, OFFBOARD_API, Rates

WIRE = Path(__file__).resolve().parents[2] / "docs" / "wire.md"
ROW = re.compile(r"^\| ([A-Z_]+) \| ([\d.]+|-) \| ([\d.]+|-) \|", re.MULTILINE)


def written() -> dict[str, tuple[float, float]]:
    rows = ROW.findall(WIRE.read_text())
    return {name: (_rate(gcs), _rate(api)) for name, gcs, api in rows}


def _rate(text: str) -> float:
    return 0.0 if text == "-" else float(text)


def test_every_stream_and_its_rates_are_documented() -> None:
    def rates(table: Rates, number: int) -> float:
        return float(table.get(number, 0.0))

    coded = {
        mavlink.mavlink_map[number].msgname: (
            rates(GROUND_STATION.at_start, number),
            rates(OFFBOARD_API.at_start, number),
        )
        for number in ENCODERS
    }
    assert written() == coded
