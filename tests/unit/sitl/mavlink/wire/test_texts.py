import pytest

from sitl.mavlink.wire.texts import statustexts


def test_a_short_text_is_one_message() -> None:
    (message,) = statustexts(6, "Ready for takeoff!\t", 4)
    assert (message.severity, message.text) == (6, "Ready for takeoff!\t")
    assert (message.id, message.chunk_seq) == (4, 0)


@pytest.mark.parametrize("length", [49, 50, 51, 99, 100, 120])
def test_a_long_text_comes_in_chunks_of_one_id_and_ends_with_one_that_is_not_full(
    length: int,
) -> None:
    text = "".join(chr(ord("a") + i % 26) for i in range(length))
    messages = statustexts(2, text, 7)
    assert "".join(message.text for message in messages) == text
    assert [message.chunk_seq for message in messages] == list(range(length // 50 + 1))
    assert {message.id for message in messages} == {7}
    assert all(len(message.text) == 50 for message in messages[:-1])
    assert len(messages[-1].text) < 50
