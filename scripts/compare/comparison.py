"""Compare what two flights said: learn what repeats from two of the same code, then look there.

Everything here is a pure function of lists of messages. A type is a source and a MAVLink message;
unless the first code's own two flights tell otherwise, its messages are equal in number, in their
place among all others and in every bit.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import Any, NamedTuple

from scripts.compare.messages import PAYLOAD, Message


class Unrepeated(NamedTuple):
    """What the first code does not repeat, by type of message."""

    fields: frozenset[tuple[str, str]] = frozenset()  # type and field: not compared
    shifted: frozenset[tuple[str, str]] = frozenset()  # compared from the first value on
    places: frozenset[str] = frozenset()  # compared among themselves, not their place among others
    types: frozenset[str] = frozenset()  # not compared: their number does not repeat

    def __str__(self) -> str:
        """Say it in a line; empty if everything repeats."""
        parts = (
            ("not compared", [*self.types, *(f"{name}.{field}" for name, field in self.fields)]),
            ("from its first value on", [f"{name}.{field}" for name, field in self.shifted]),
            ("not its place among others", self.places),
        )
        return "; ".join(f"{how}: {', '.join(sorted(what))}" for how, what in parts if what)


class Difference(NamedTuple):
    """The first thing in which two flights differ."""

    place: int  # among the messages of the first flight
    name: str
    field: str
    first: str
    second: str

    def __str__(self) -> str:
        """Say it in a line."""
        where = f"message {self.place}: {self.name}{self.field and '.' + self.field}"
        return f"{where} was {self.first}, is {self.second}"


class Entry(NamedTuple):
    """A message, and of it what is compared."""

    place: int
    message: Message
    value: Any


def learn(first: Sequence[Message], again: Sequence[Message]) -> Unrepeated:
    """Find what two flights of the same code do not have in common, as narrowly as possible."""
    one, other = _by_name(first), _by_name(again)
    types = {name for name in one.keys() | other.keys() if len(one[name]) != len(other[name])}
    fields, shifted = set[tuple[str, str]](), set[tuple[str, str]]()
    for name in one.keys() - types:
        pairs = list(zip(one[name], other[name], strict=True))
        for field in sorted({field for a, b in pairs for field in _unequal(a, b)}):
            (shifted if _is_shifted(pairs, field) else fields).add((name, field))
    names = [[m.name for m in flight if m.name not in types] for flight in (first, again)]
    return Unrepeated(
        frozenset(fields), frozenset(shifted), frozenset(_out_of_order(*names)), frozenset(types)
    )


def learn_all(flights: Sequence[Sequence[Message]]) -> Unrepeated:
    """Find what any of several flights of the same code does not have in common with the first."""
    first, *others = flights
    found = [learn(first, again) for again in others]
    fields = frozenset[tuple[str, str]]().union(*(one.fields for one in found))
    return Unrepeated(
        fields,
        frozenset[tuple[str, str]]().union(*(one.shifted for one in found)) - fields,
        frozenset[str]().union(*(one.places for one in found)),
        frozenset[str]().union(*(one.types for one in found)),
    )


def compare(
    first: Sequence[Message], second: Sequence[Message], unrepeated: Unrepeated
) -> Difference | None:
    """Find the first difference in what repeats."""
    one, other = _lanes(first, unrepeated), _lanes(second, unrepeated)
    found = (_first_difference(one[lane], other[lane]) for lane in one.keys() | other.keys())
    return min((difference for difference in found if difference is not None), default=None)


def _first_difference(first: list[Entry], second: list[Entry]) -> Difference | None:
    for a, b in zip_longest(first, second):
        if a is None or b is None or a.message.name != b.message.name:
            place = b.place if a is None else a.place
            return Difference(place, "it", "", _told(a), _told(b))
        if a.value != b.value:
            one, other = _shown(a), _shown(b)
            field = next(key for key in one | other if one.get(key) != other.get(key))
            texts = (str(shown.get(field)) for shown in (one, other))
            return Difference(a.place, a.message.name, field, *texts)
    return None


def _shown(entry: Entry) -> dict[str, str]:
    """Give what is compared of a message, field by field, then the bits that no field shows."""
    if entry.value and isinstance(entry.value[0], bytes):
        fields = {key: repr(value) for key, value in entry.message.fields().items()}
        return fields | {PAYLOAD: entry.message.payload.hex()}
    return dict(entry.value)


def _told(entry: Entry | None) -> str:
    if entry is None:
        return "missing"
    values = {key: value for key, value in entry.message.fields().items() if key[0] != "("}
    return f"{entry.message.name} {values}"


def _lanes(messages: Sequence[Message], unrepeated: Unrepeated) -> dict[str, list[Entry]]:
    """Sort messages by what keeps its order: all together, but for those without a place."""
    lanes: dict[str, list[Entry]] = defaultdict(list)
    bases: dict[tuple[str, str], Any] = {}
    special = {name for name, _ in unrepeated.fields | unrepeated.shifted}
    for place, message in enumerate(messages):
        name = message.name
        if name in unrepeated.types:
            continue
        value: Any = (message.payload, message.step)
        if name in special:
            value = tuple(_comparable(message, unrepeated, bases))
        lanes[name if name in unrepeated.places else ""].append(Entry(place, message, value))
    return lanes


def _comparable(
    message: Message, unrepeated: Unrepeated, bases: dict[tuple[str, str], Any]
) -> Iterator[tuple[str, str]]:
    for field, value in message.fields().items():
        key = (message.name, field)
        if key in unrepeated.shifted:
            yield field, repr(value - bases.setdefault(key, value))
        elif key not in unrepeated.fields:
            yield field, repr(value)


def _by_name(messages: Sequence[Message]) -> dict[str, list[Message]]:
    found: dict[str, list[Message]] = defaultdict(list)
    for message in messages:
        found[message.name].append(message)
    return found


def _unequal(a: Message, b: Message) -> list[str]:
    """Name the fields in which two messages of a type differ."""
    if (a.payload, a.step) == (b.payload, b.step):
        return []
    one, other = a.fields(), b.fields()
    names = [key for key in one | other if repr(one.get(key)) != repr(other.get(key))]
    return names or [PAYLOAD]  # bits that no field shows


def _is_shifted(pairs: list[tuple[Message, Message]], field: str) -> bool:
    """Whether a whole number differs by the same amount throughout, as a stamp does."""
    values = [(a.fields().get(field), b.fields().get(field)) for a, b in pairs]
    if len(values) < 2 or not all(type(a) is type(b) is int for a, b in values):
        return False
    return len({b - a for a, b in values if a is not None and b is not None}) == 1


def _out_of_order(first: list[str], again: list[str]) -> set[str]:
    """Find the types without which the others come in the same order."""
    dropped: set[str] = set()
    while (at := _first_mismatch(first, again)) is not None:
        tried = []
        for name in {first[at], again[at]}:
            without = [[n for n in names if n != name] for names in (first, again)]
            reached = _first_mismatch(*without)
            tried.append((len(without[0]) if reached is None else reached, name, without))
        _, name, (first, again) = max(tried)
        dropped.add(name)
    return dropped


def _first_mismatch(first: list[str], again: list[str]) -> int | None:
    """Where two orders of the same names part."""
    return next((i for i, (a, b) in enumerate(zip(first, again, strict=True)) if a != b), None)
