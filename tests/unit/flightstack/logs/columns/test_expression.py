import numpy as np
import pytest

from flightstack.logs import Log, read_bytes
from flightstack.logs.columns.expression import holds, parse, series
from flightstack.logs.errors import ExpressionError, UnknownNameError
from tests.unit.flightstack.logs.made_flights import make_flight


@pytest.fixture(scope="module")
def log() -> Log:
    return read_bytes(make_flight(5.0))


def test_a_field_is_a_series_with_its_unit(log: Log) -> None:
    times, values, unit = series("ATTITUDE.yaw", log)
    table = log["ATTITUDE"]
    assert unit == "rad"
    assert times.tolist() == table.time_us.tolist()
    assert values.tolist() == table["yaw"].astype(float).tolist()


def test_functions_and_arithmetic_are_computed_on_columns(log: Log) -> None:
    _, degrees, _ = series("degrees(ATTITUDE.yaw) - 90", log)
    assert np.allclose(degrees, np.degrees(log["ATTITUDE"]["yaw"].astype(float)) - 90)
    _, last, _ = series("DEBUG_FLOAT_ARRAY.data[27]", log)
    assert np.array_equal(last, log["DEBUG_FLOAT_ARRAY"]["data"][:, 27].astype(float))


def test_a_condition_uses_the_latest_value_of_each_message(log: Log) -> None:
    rows = np.arange(len(log))
    armed = holds("HEARTBEAT.base_mode & 128 and HEARTBEAT.autopilot == 12", log, rows)
    beats = log["HEARTBEAT"].where(component=1)
    first = int(beats.row[np.argmax(beats["base_mode"] & 128 > 0)])
    assert not armed[:first].any()
    assert armed[first]


def test_a_condition_on_an_unseen_message_never_holds(log: Log) -> None:
    assert not holds("GPS_RAW_INT.fix_type >= 0", log, np.arange(len(log))).any()


def test_text_compares_with_text(log: Log) -> None:
    rows = log["STATUSTEXT"].row
    said = holds("STATUSTEXT.text == 'Passed gate 1 of 32'", log, rows)
    assert said.tolist() == [t == "Passed gate 1 of 32" for t in log["STATUSTEXT"]["text"]]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("ATTITUDE.roll >", "does not parse"),
        ("ATITUDE.roll > 0", "did you mean ATTITUDE"),
        ("ATTITUDE.rol > 0", "did you mean"),
        ("roll > 0", "is not MESSAGE.field"),
        ("__import__('os').system('true')", "no function"),
        ("ATTITUDE.roll.__class__", "is not MESSAGE.field"),
        ("open('x')", "no function 'open'"),
        ("[x for x in (1, 2)]", "is not allowed"),
        ("ATTITUDE.roll[0] > 1", "is not an array field"),
        ("DEBUG_FLOAT_ARRAY.data[99] > 1", "has 58 elements"),
        ("DEBUG_FLOAT_ARRAY.data > 1", "is no condition"),
        ("STATUSTEXT.text + 1", "cannot be computed"),
        ("min(ATTITUDE.roll)", "cannot be computed"),
        ("STATUSTEXT.text", "is no condition"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(log: Log, text: str, reason: str) -> None:
    with pytest.raises((ExpressionError, UnknownNameError), match=reason) as caught:
        holds(text, log, np.arange(len(log)))
    assert "\n" not in str(caught.value)


def test_series_say_what_cannot_be_drawn(log: Log) -> None:
    for text, reason in (
        ("DEBUG_FLOAT_ARRAY.data", "name one element"),
        ("STATUSTEXT.text", "it is text"),
        ("GPS_RAW_INT.eph", "holds no GPS_RAW_INT"),
        ("1 + 1", "reads no message"),
    ):
        with pytest.raises((ExpressionError, UnknownNameError), match=reason):
            series(text, log)


def test_parse_names_the_messages_that_are_read() -> None:
    assert parse("ATTITUDE.roll > VFR_HUD.alt + ATTITUDE.yaw").messages == ("ATTITUDE", "VFR_HUD")
