"""Keep the parameters that were changed in a file, in the form that ground stations save them in.

A line is `system<TAB>component<TAB>name<TAB>value<TAB>type`; lines that begin with # are comments.
"""

import logging
import os
from pathlib import Path

from sitl.autopilot.parameters import Parameters
from sitl.errors import UsageError
from sitl.process.options.file_replacement import replace_file

HEADER = "# Parameters that differ from their defaults\n# Vehicle\tcomponent\tname\tvalue\ttype\n"
FIELDS = 5
COMPONENT = 1  # the autopilot
OWN = {"MAV_SYS_ID", "MAV_COMP_ID"}  # the first follows from the instance, the second is 1

_log = logging.getLogger(__name__)


class ParameterFile:
    """Reads the file once, and writes it whenever there is something new to keep."""

    def __init__(self, path: Path, parameters: Parameters) -> None:
        """Load what the file holds; a file that isn't there yet is empty.

        Names that this vehicle doesn't know are passed over: the file may be another vehicle's.

        Raises:
            UsageError: the file can't be read or kept, a line has another form, or a value can't
                be.

        """
        self._path = path.resolve()  # a link stays one
        self._parameters = parameters
        self._load()
        self._saved = parameters.values

    def save(self) -> None:
        """Write the file if a parameter has changed since; the old one is replaced as a whole."""
        parameters = self._parameters
        if parameters.values is self._saved:
            return
        self._saved = parameters.values
        lines = [self._line(name) for name in parameters.names() if self._is_changed(name)]
        try:
            replace_file(self._path, HEADER + "".join(lines))
        except OSError as error:
            _log.error("parameters not saved to %s: %s", self._path, error.strerror)

    def _load(self) -> None:
        folder = self._path.parent
        if not (folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)):
            raise UsageError(f"--params: can't write to the folder {folder}")
        try:
            text = self._path.read_text() if self._path.exists() else ""
        except (OSError, UnicodeDecodeError) as error:
            raise UsageError(f"--params: can't read {self._path}: {error}") from None
        unknown = 0
        for number, line in enumerate(text.splitlines(), 1):
            if not line.strip() or line.startswith("#"):
                continue
            fields = line.split("\t")
            if len(fields) != FIELDS:
                raise UsageError(
                    f"--params: {self._path} line {number}: expected {FIELDS} fields between tabs"
                )
            name, value = fields[2:4]
            if name not in self._parameters:
                unknown += 1
                continue
            try:
                self._parameters.set_from_text(name, value)
            except UsageError as error:
                raise UsageError(f"--params: {self._path} line {number}: {error}") from None
        if unknown:
            _log.warning("%s: %d parameters that this vehicle has not", self._path, unknown)

    def _is_changed(self, name: str) -> bool:
        default = self._parameters.specification(name).default
        return name not in OWN and self._parameters.get(name) != default

    def _line(self, name: str) -> str:
        parameters = self._parameters
        system, kind = parameters.get("MAV_SYS_ID"), int(parameters.type_of(name))
        return f"{system}\t{COMPONENT}\t{name}\t{parameters.get(name)!r}\t{kind}\n"
