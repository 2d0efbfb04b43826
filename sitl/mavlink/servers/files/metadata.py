"""Describe the vehicle to ground stations: the component metadata, as files in its folder."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from sitl.mavlink.wire.crc32 import crc32
from sitl.mavlink.wire.dialect import Message
from sitl.mavlink.wire.newer_messages import ComponentMetadata

GENERAL, PARAMETERS = "general.json", "parameters.json"
TYPE_PARAMETER = 1  # COMP_METADATA_TYPE
URI = "mftp:///{}"  # by FILE_TRANSFER_PROTOCOL, from "/"


class Metadata:
    """The written files, and the message that leads to them."""

    def __init__(self, folder: Path, parameters: Iterable[Mapping[str, Any]]) -> None:
        """Write the files; `parameters` in the words of the parameter metadata."""
        described = _write(folder / PARAMETERS, {"version": 1, "parameters": list(parameters)})
        types = [{"type": TYPE_PARAMETER, "uri": URI.format(PARAMETERS), "fileCrc": described}]
        self._crc = _write(folder / GENERAL, {"version": 1, "metadataTypes": types})

    def message(self, time_us: int) -> Message:
        """COMPONENT_METADATA."""
        return ComponentMetadata(time_us // 1000, self._crc, URI.format(GENERAL).encode())


def _write(path: Path, content: Mapping[str, Any]) -> int:
    data = json.dumps(content, separators=(",", ":")).encode()
    path.write_bytes(data)
    return crc32(data)
