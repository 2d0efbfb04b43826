"""Write a file whole or not at all: a kill at any moment leaves the old one or the new one.

Not by pathlib, whose import takes 4 ms: the commands on logs use this file, and start in 30.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[str]:
    """Give the name of a draft beside `path`; it takes the place of `path` at the block's end.

    Where the block fails, `path` stays as it was and no draft is left. Every process has a draft of
    its own: of two that write the same file, one wins.
    """
    draft = f"{os.fspath(path)}.{os.getpid()}.part"
    try:
        yield draft
        os.replace(draft, path)  # noqa: PTH105
    except BaseException:
        with suppress(OSError):
            os.unlink(draft)  # noqa: PTH108
        raise


def write_whole(
    path: str | os.PathLike[str], content: str | bytes | memoryview, *, durable: bool = False
) -> None:
    """Write bytes, or text as UTF-8 with its line ends as they are.

    A `durable` file is on the disk when this returns, and survives a loss of power.
    """
    data = content.encode() if isinstance(content, str) else content
    with replacing(path) as draft, open(draft, "wb") as file:  # noqa: PTH123
        file.write(data)
        if durable:
            file.flush()
            os.fsync(file.fileno())
