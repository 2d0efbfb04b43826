"""Commands are sent until they are acknowledged, in the time of whoever asks."""

import math
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from flightstack.mavlink import commands
from flightstack.mavlink.commands import CommandRefusal, CommandSender, command_name
from flightstack.px4_modes import Px4Mode
from tests.unit.flightstack.mavlink.made_link import MadeLink, heartbeat

RETRY_US = 500_000


class Sender:
    def __init__(self, folder: Path) -> None:
        self.made = MadeLink(folder)
        self.made.say(heartbeat())
        self.made.link.drain()
        self.commands = CommandSender(self.made.link)

    def answer(self, number: int, result: int, *, target: int = 191) -> CommandRefusal | None:
        self.made.say(common.MAVLink_command_ack_message(number, result, 0, 0, 3, target))
        (ack,) = self.made.link.drain()
        return self.commands.acknowledge(ack)


@pytest.fixture
def sender(tmp_path: Path) -> Sender:
    return Sender(tmp_path)


def test_an_acknowledged_command_is_sent_once(sender: Sender) -> None:
    sender.commands.request(commands.arm(), 0)
    assert sender.answer(400, common.MAV_RESULT_ACCEPTED) is None
    assert sender.commands.poll(10 * RETRY_US) == []
    (sent,) = sender.made.sent()
    assert (sent.command, sent.target_system, sent.target_component) == (400, 3, 1)
    assert sent.param1 == 1


def test_a_lost_command_is_sent_three_times_more_then_given_up(sender: Sender) -> None:
    sender.commands.request(commands.land(), 0)
    assert sender.commands.poll(RETRY_US - 1) == []
    given_up = [sender.commands.poll(k * RETRY_US) for k in (1, 2, 3, 4, 5)]
    assert given_up == [[], [], [], [CommandRefusal(commands.land(), "not acknowledged")], []]
    assert [message.confirmation for message in sender.made.sent()] == [0, 1, 2, 3]


def test_an_answer_to_somebody_else_is_not_ours(sender: Sender) -> None:
    sender.commands.request(commands.arm(), 0)
    assert sender.answer(400, common.MAV_RESULT_DENIED, target=190) is None
    sender.commands.poll(RETRY_US)
    assert len(sender.made.sent()) == 2


def test_a_denial_says_why(sender: Sender) -> None:
    sender.commands.request(commands.arm(), 0)
    refusal = sender.answer(400, common.MAV_RESULT_TEMPORARILY_REJECTED)
    assert refusal == CommandRefusal(commands.arm(), "temporarily_rejected")


def test_a_mode_may_be_refused_in_the_second_answer(sender: Sender) -> None:
    offboard = commands.set_mode(Px4Mode.OFFBOARD)
    sender.commands.request(offboard, 0)
    assert sender.answer(176, common.MAV_RESULT_ACCEPTED) is None
    refusal = sender.answer(176, common.MAV_RESULT_TEMPORARILY_REJECTED)
    assert refusal == CommandRefusal(offboard, "temporarily_rejected")


def test_an_answer_that_was_not_requested_is_passed_over(sender: Sender) -> None:
    assert sender.answer(400, common.MAV_RESULT_DENIED) is None


def test_take_off_leaves_the_place_to_the_vehicle() -> None:
    params = commands.take_off(492.4).params
    assert params[6] == 492.4
    assert all(map(math.isnan, params[3:6]))


def test_modes_are_split_into_main_and_sub() -> None:
    assert commands.set_mode(Px4Mode.OFFBOARD).params[:3] == (1, 6, 0)
    assert commands.set_mode(Px4Mode.LOITER).params[:3] == (1, 4, 3)


def test_commands_have_names() -> None:
    assert command_name(commands.arm()) == "COMPONENT_ARM_DISARM"
