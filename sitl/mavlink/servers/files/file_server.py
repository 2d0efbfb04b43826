"""Answer FILE_TRANSFER_PROTOCOL: read what is in the vehicle's folder; everything else is a NAK.

A request that comes again (its answer was lost) gets the same answer again. A burst is sent at
once, but only so much of it: the client asks for the rest. Sessions are few; one that has not
been used for a while gives way to a new one.
"""

import os
import struct
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sitl.clock import SECOND_US
from sitl.mavlink.servers.files.file_transfer import (
    ACK,
    DATA_BYTES,
    NAK,
    FileQuery,
    FileReply,
    Opcode,
    Problem,
    accept,
    read_query,
    refuse,
)
from sitl.mavlink.servers.files.vehicle_files import ForbiddenPathError, VehicleFiles
from sitl.mavlink.servers.request import Outlet, Request
from sitl.mavlink.wire.crc32 import crc32
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.mavlink.wire.refusals import Refusal, Refusals

SIZE = struct.Struct("<I")
MAX_SESSIONS = 4
IDLE_US = 10 * SECOND_US  # a session that nobody used for so long may be taken
BURST_PACKETS = 32
MAX_CRC_BYTES = 8 << 20  # a checksum must not hold up the flight
MAX_CLIENTS = 8  # whose last answer is remembered


class FileProblemError(Exception):
    """A request that is answered by a NAK."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.name)
        self.problem = problem


@dataclass(slots=True)
class _Session:
    descriptor: int
    size: int
    used_us: int


Client = tuple[Outlet, int, int]  # link, system, component


class FileServer:
    """One vehicle's files on all its links; close it to close what is open."""

    def __init__(
        self, files: VehicleFiles, clock: Callable[[], int], refusals: Refusals | None = None
    ) -> None:
        """Serve a folder; `clock` gives vehicle time in us."""
        self._files = files
        self._clock = clock
        self._refusals = refusals or Refusals()
        self._sessions: dict[int, _Session] = {}
        self._answered: OrderedDict[Client, tuple[FileQuery, list[bytes]]] = OrderedDict()
        self._answers: Mapping[int, Callable[[FileQuery], list[FileReply]]] = {
            Opcode.NONE: lambda query: [FileReply(query.session, b"")],
            Opcode.TERMINATE_SESSION: self._terminate,
            Opcode.RESET_SESSIONS: self._reset,
            Opcode.LIST_DIRECTORY: self._list,
            Opcode.OPEN_FILE: self._open,
            Opcode.READ_FILE: self._read,
            Opcode.CRC32: self._checksum,
            Opcode.BURST_READ: self._burst,
        }

    def close(self) -> None:
        """Close all files."""
        for number in list(self._sessions):
            self._end(number)

    def answer(self, message: Message, request: Request) -> None:
        """Answer FILE_TRANSFER_PROTOCOL."""
        query = read_query(bytes(message.payload))
        if query.opcode in (ACK, NAK):
            return
        client = (request.outlet, request.system, request.component)
        last, payloads = self._answered.get(client, (None, []))
        if last != query:
            payloads = self._reply(query)
            self._answered[client] = (query, payloads)
            self._answered.move_to_end(client)
            while len(self._answered) > MAX_CLIENTS:
                self._answered.popitem(last=False)
        for payload in payloads:
            request.outlet.send(
                mavlink.MAVLink_file_transfer_protocol_message(
                    0, request.system, request.component, payload
                )
            )

    def _reply(self, query: FileQuery) -> list[bytes]:
        try:
            answers = self._answer(query)
        except FileProblemError as error:
            return [refuse(query, error.problem)]
        return [accept(query, answer, number) for number, answer in enumerate(answers)]

    def _answer(self, query: FileQuery) -> list[FileReply]:
        if query.size > DATA_BYTES:
            raise FileProblemError(Problem.INVALID_SIZE)
        answer = self._answers.get(query.opcode)
        if answer is None:
            raise FileProblemError(Problem.UNKNOWN_COMMAND)
        try:
            return answer(query)
        except ForbiddenPathError:
            self._refusals.note([Refusal.FILE_ACCESS])
            raise FileProblemError(Problem.PROTECTED) from None
        except FileNotFoundError:
            raise FileProblemError(Problem.NOT_FOUND) from None
        except OSError:
            raise FileProblemError(Problem.FAIL) from None

    def _terminate(self, query: FileQuery) -> list[FileReply]:
        if query.session not in self._sessions:
            raise FileProblemError(Problem.INVALID_SESSION)
        self._end(query.session)
        return [FileReply(query.session, b"")]

    def _reset(self, _query: FileQuery) -> list[FileReply]:
        self.close()
        return [FileReply(0, b"")]

    def _list(self, query: FileQuery) -> list[FileReply]:
        entries = self._files.entries(query.path)[query.offset :]
        if not entries:
            raise FileProblemError(Problem.END_OF_FILE)
        data = b""
        for name, size in entries:
            line = f"D{name}" if size is None else f"F{name}\t{size}"
            encoded = line.encode(errors="surrogateescape") + b"\0"
            if len(encoded) > DATA_BYTES:
                encoded = b"S\0"  # skipped, but counted
            if len(data) + len(encoded) > DATA_BYTES:
                break
            data += encoded
        return [FileReply(query.session, data, query.offset)]

    def _open(self, query: FileQuery) -> list[FileReply]:
        number = self._free_session()
        descriptor = self._files.open(query.path)
        size = os.fstat(descriptor).st_size
        self._sessions[number] = _Session(descriptor, size, self._clock())
        return [FileReply(number, SIZE.pack(min(size, 0xFFFFFFFF)))]

    def _read(self, query: FileQuery) -> list[FileReply]:
        data = self._piece(query, query.offset)
        return [FileReply(query.session, data, query.offset)]

    def _burst(self, query: FileQuery) -> list[FileReply]:
        answers: list[FileReply] = []
        size = self._session(query).size
        end = min(size, query.offset + BURST_PACKETS * (query.size or DATA_BYTES))
        offset = query.offset
        while offset < end or not answers:
            data = self._piece(query, offset)
            answers.append(FileReply(query.session, data, offset, is_last=False))
            offset += len(data)
        return [*answers[:-1], answers[-1]._replace(is_last=True)]

    def _piece(self, query: FileQuery, offset: int) -> bytes:
        session = self._session(query)
        wanted = min(query.size or DATA_BYTES, max(0, session.size - offset))
        data = os.pread(session.descriptor, wanted, offset) if wanted else b""
        if not data:
            raise FileProblemError(Problem.END_OF_FILE)
        return data

    def _checksum(self, query: FileQuery) -> list[FileReply]:
        descriptor = self._files.open(query.path)
        with os.fdopen(descriptor, "rb") as file:
            content = file.read(MAX_CRC_BYTES + 1)
        if len(content) > MAX_CRC_BYTES:
            raise FileProblemError(Problem.FAIL)
        return [FileReply(query.session, SIZE.pack(crc32(content)))]

    def _session(self, query: FileQuery) -> _Session:
        session = self._sessions.get(query.session)
        if session is None:
            raise FileProblemError(Problem.INVALID_SESSION)
        session.used_us = self._clock()
        return session

    def _free_session(self) -> int:
        for number in range(MAX_SESSIONS):
            if number not in self._sessions:
                return number
        oldest = min(self._sessions, key=lambda number: self._sessions[number].used_us)
        if self._clock() - self._sessions[oldest].used_us < IDLE_US:
            raise FileProblemError(Problem.NO_SESSIONS)
        self._end(oldest)
        return oldest

    def _end(self, number: int) -> None:
        os.close(self._sessions.pop(number).descriptor)
