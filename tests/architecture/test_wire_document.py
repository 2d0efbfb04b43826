"""The document of the wire tells the rates and the messages that the code has."""

import re

from sitl.mavlink.streams.encoders import ENCODERS
from sitl.mavlink.streams.rates import GROUND_STATION, OFFBOARD_API, Rates
from sitl.mavlink.wire.dialect import mavlink
from tests.paths import DOCS

WIRE = DOCS / "wire.md"
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
