"""What is exported holds what the log holds."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from flightstack.logs import Log, read_bytes
from flightstack.logs.export.csv import write_csv
from flightstack.logs.export.mcap import write_mcap
from flightstack.logs.export.parquet import write_parquet
from tests.unit.flightstack.logs.made_flights import make_flight
from tests.unit.flightstack.logs.made_logs import START_US, packet, record


@pytest.fixture(scope="module")
def log() -> Log:
    quoted = packet(253, b'\6say "hi", he said' + bytes(36), system=9)
    unknown = [packet(54321, b"\1\2", extra=4, sequence=i) for i in range(2)]
    more = b"".join(record(START_US + 90_000_000, raw) for raw in (quoted, *unknown))
    return read_bytes(make_flight(4.0) + more)


def test_csv_holds_every_value(log: Log, tmp_path: Path) -> None:
    write_csv([log], tmp_path)
    with (tmp_path / "ATTITUDE.csv").open() as file:
        rows = list(csv.DictReader(file))
    table = log["ATTITUDE"]
    assert [float(row["yaw"]) for row in rows] == table["yaw"].astype(float).tolist()
    assert [round(float(row["time_s"]) * 1e6) for row in rows] == table.time_us.tolist()
    with (tmp_path / "STATUSTEXT.csv").open() as file:
        texts = [row["text"] for row in csv.DictReader(file)]
    assert texts == log["STATUSTEXT"]["text"].tolist()
    assert 'say "hi", he said' in texts
    with (tmp_path / "DEBUG_FLOAT_ARRAY.csv").open() as file:
        last = [float(row["data[27]"]) for row in csv.DictReader(file)]
    assert last == log["DEBUG_FLOAT_ARRAY"]["data"][:, 27].astype(float).tolist()


def test_parquet_holds_every_value_with_units(log: Log, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    write_parquet([log], tmp_path)
    table = parquet.read_table(tmp_path / "ATTITUDE.parquet")
    assert np.array_equal(table["yaw"].to_numpy(), log["ATTITUDE"]["yaw"])
    assert table.schema.field("yaw").metadata[b"unit"] == b"rad"
    stamps = table["time"].cast("int64").to_numpy()
    assert stamps.tolist() == log["ATTITUDE"].time_us.tolist()
    arrays = parquet.read_table(tmp_path / "DEBUG_FLOAT_ARRAY.parquet")
    assert len(arrays["data"][0]) == 58


def test_mcap_holds_every_message_in_order(log: Log, tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    path = tmp_path / "flight.mcap"
    write_mcap([log], path)
    with path.open("rb") as file:
        found = list(reader.make_reader(file).iter_messages(log_time_order=False))
    assert len(found) == len(log)
    assert [message.log_time for _, _, message in found] == (log.time_us * 1000).tolist()
    yaws = [
        json.loads(message.data)["yaw"]
        for _, channel, message in found
        if channel.topic == "/1/1/ATTITUDE"
    ]
    assert yaws == log["ATTITUDE"]["yaw"].astype(float).tolist()
    schemas = {schema.name: json.loads(schema.data) for schema, _, _ in found}
    yaw = schemas["mavlink.ATTITUDE"]["properties"]["yaw"]
    assert yaw == {"type": "number", "description": "[rad]"}
