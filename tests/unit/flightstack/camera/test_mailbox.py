"""One slot between two threads: the newest image, and a bell that rings for it."""

import select
import threading

import numpy as np

from flightstack.camera.mailbox import Arrival, Mailbox
from flightstack.records import Image


def arrival(number: int) -> Arrival:
    rgb = np.zeros((2, 2, 3), np.uint8)
    return Arrival(Image(stamp_us=number, sequence=number, rgb=rgb), 0.0)


def is_ringing(mailbox: Mailbox) -> bool:
    return bool(select.select([mailbox], [], [], 0)[0])


def test_an_empty_box_is_silent() -> None:
    mailbox = Mailbox()
    assert not is_ringing(mailbox)
    assert mailbox.take() is None
    mailbox.close()


def test_only_the_newest_image_is_kept() -> None:
    mailbox = Mailbox()
    for number in range(1000):
        mailbox.put(arrival(number))
    assert is_ringing(mailbox)
    taken = mailbox.take()
    assert taken is not None
    assert taken.image.stamp_us == 999
    assert not is_ringing(mailbox)
    assert mailbox.take() is None
    mailbox.close()


def test_wakes_a_thread_that_waits() -> None:
    mailbox = Mailbox()
    thread = threading.Thread(target=mailbox.put, args=[arrival(7)])
    thread.start()
    assert select.select([mailbox], [], [], 5)[0]
    assert mailbox.take() is not None
    thread.join()
    mailbox.close()


def test_an_image_for_a_closed_box_goes_nowhere() -> None:
    mailbox = Mailbox()
    mailbox.close()
    mailbox.put(arrival(1))
    assert mailbox.take() is None
