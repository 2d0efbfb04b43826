"""The referee's gates are requested one by one, at the caller's pace, and nobody waits for them."""

from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common

from flightstack.mavlink.course_download import MAX_GATES, CourseDownload, DownloadStage
from tests.unit.flightstack.mavlink.made_link import MadeLink, heartbeat

IMAGE_US = 50_000
RETRY_US = 500_000


def count(gates: int, *, target: int = 191) -> Any:
    return common.MAVLink_mission_count_message(3, target, gates, 0)


def item(seq: int) -> Any:
    return common.MAVLink_mission_item_int_message(
        *(3, 191, seq, 1, 16, 0, 1), *(0.0, 0.7, 0.0, 90.0), *(47_000, 10_000, -3.0, 0)
    )


class Download:
    def __init__(self, folder: Path) -> None:
        self.made = MadeLink(folder)
        self.made.say(heartbeat())
        self.made.link.drain()
        self.download = CourseDownload(self.made.link)

    def poll(self, now_us: int) -> list[tuple[Any, ...]]:
        """What goes out, as (name, seq where there is one)."""
        before = len(self.made.transport.sent)
        self.download.poll(now_us)
        sent = self.made.sent()[before:]
        assert all((m.target_system, m.target_component) == (3, 25) for m in sent)
        return [(m.get_type(), *([m.seq] if hasattr(m, "seq") else [])) for m in sent]

    def hear(self, message: Any, component: int = 25) -> None:
        self.made.say(message, component=component)
        before = len(self.made.transport.sent)
        for heard in self.made.link.drain():
            self.download.take(heard)
        assert len(self.made.transport.sent) == before  # only `poll` speaks


@pytest.fixture
def download(tmp_path: Path) -> Download:
    return Download(tmp_path)


def test_requests_one_item_per_image_and_closes(download: Download) -> None:
    sent = [download.poll(0)]
    download.hear(count(2))
    for seq in range(2):
        sent.append(download.poll((1 + seq) * IMAGE_US))
        download.hear(item(seq))
    sent += [download.poll(3 * IMAGE_US), download.poll(4 * IMAGE_US)]
    assert sent == [
        [("MISSION_REQUEST_LIST",)],
        [("MISSION_REQUEST_INT", 0)],
        [("MISSION_REQUEST_INT", 1)],
        [("MISSION_ACK",)],
        [],
    ]
    assert download.download.items == 2


def test_a_lost_answer_is_requested_again(download: Download) -> None:
    download.poll(0)
    download.hear(count(1))
    assert download.poll(IMAGE_US) == [("MISSION_REQUEST_INT", 0)]
    assert download.poll(IMAGE_US + RETRY_US - 1) == []
    assert download.poll(IMAGE_US + RETRY_US) == [("MISSION_REQUEST_INT", 0)]
    download.hear(item(0))
    assert download.poll(2 * RETRY_US) == [("MISSION_ACK",)]


def test_gives_up_in_silence_where_nobody_answers(download: Download) -> None:
    sent = [download.poll(k * RETRY_US) for k in range(6)]
    assert sent == [[("MISSION_REQUEST_LIST",)]] * 4 + [[], []]
    assert download.download.stage is DownloadStage.DONE
    download.hear(count(1))
    assert download.poll(10 * RETRY_US) == []


@pytest.mark.parametrize("gates", [0, MAX_GATES + 1, 65535])
def test_downloads_neither_nothing_nor_the_absurd(download: Download, gates: int) -> None:
    download.poll(0)
    download.hear(count(gates))
    assert download.poll(RETRY_US) == []


def test_only_what_is_awaited_counts(download: Download) -> None:
    download.poll(0)
    download.hear(item(0))  # before its count
    download.hear(count(2, target=190))  # to somebody else
    download.hear(count(2), component=1)  # the autopilot's own mission
    assert download.download.stage is DownloadStage.LISTING
    download.hear(count(2))
    download.poll(IMAGE_US)
    download.hear(item(1))
    assert download.download.items == 0
    download.hear(item(0))
    download.hear(item(0))
    assert download.download.items == 1
