"""Events of a log while it grows."""

from flightstack.logs.columns.live import PieceReader
from flightstack.logs.facts.events import LiveEvents
from tests.unit.flightstack.logs.made_flights import make_flight


def test_events_are_told_once_and_in_order() -> None:
    live = LiveEvents()
    whole = make_flight(6.0)
    reader = PieceReader()
    events = [
        event
        for at in range(0, len(whole), 999)
        for event in live.of(reader.feed(whole[at : at + 999]))
    ]
    told = [(event["event"], event["text"]) for event in events if event["event"] != "text"]
    assert told == [
        ("mode", "AUTO.LOITER"),
        ("mode", "AUTO.TAKEOFF"),
        ("armed", ""),
        ("mode", "OFFBOARD"),
        ("gate", "gate 0 reached"),
        ("mode", "AUTO.LAND"),
        ("disarmed", ""),
    ]
    assert sum(event["event"] == "text" for event in events) == 3
    assert live.rates(1.0)["sources"]["1/1"]["loss_percent"] == 0.0
