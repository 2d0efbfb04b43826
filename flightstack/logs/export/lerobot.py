"""Write flights as a LeRobot dataset: one episode a flight, its images as a film of their own."""

import json
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.libraries import load_library
from flightstack.logs.errors import LogFileError
from flightstack.logs.export import lerobot_meta as meta
from flightstack.logs.export.episode import Episode

CODEC, LOSSLESS_ENOUGH = "libx264", {"crf": "18", "g": "2"}  # every other picture stands alone
Rgb = NDArray[np.uint8]


class DatasetWriter:
    """A dataset that grows by episodes; all have images of one size and one rate."""

    def __init__(self, folder: Path, task: str) -> None:
        """Begin one; raises LogFileError where the folder holds something."""
        if folder.exists() and any(folder.iterdir()):
            raise LogFileError(f"{folder} is not empty: a dataset gets a folder of its own")
        self._arrow = load_library("pyarrow", "logs")
        self._parquet = load_library("pyarrow.parquet", "logs")
        self._av = load_library("av", "video")
        self._folder = folder
        self._task = task
        self._rows: list[meta.Json] = []  # of the table of episodes
        self._columns: dict[str, list[NDArray[Any]]] = {}
        self._seen: list[Rgb] = []  # some images, for their statistics
        self._shape: tuple[int, int] | None = None
        self._rate_hz = 0
        self._frames = 0

    def add(self, episode: Episode) -> None:
        """Add a flight; raises LogFileError where its images are of another size or rate."""
        images = np.stack([_image(path) for path in episode.paths])
        shape = (images.shape[1], images.shape[2])
        if self._shape not in (None, shape) or self._rate_hz not in (0, episode.rate_hz):
            raise LogFileError(
                f"{episode.paths[0].parent}: images of {shape[1]} x {shape[0]} at "
                f"{episode.rate_hz} Hz, others before it are not; make a dataset of each kind"
            )
        self._shape, self._rate_hz = shape, episode.rate_hz
        number = len(self._rows)
        columns = self._table(episode, number)
        self._write_table(columns, meta.DATA.format(chunk_index=0, file_index=number))
        self._write_film(images, number)
        for key, values in columns.items():
            self._columns.setdefault(key, []).append(values)
        self._seen.append(images[:: max(len(images) // 50, 1)])
        self._rows.append(self._row(number, len(episode)))
        self._frames += len(episode)

    def close(self) -> None:
        """Write what the dataset says of itself."""
        if self._shape is None:
            raise LogFileError("no flight with decisions on recorded images: nothing to write")
        height, width = self._shape
        sizes = {"rate_hz": self._rate_hz, "height": height, "width": width}
        told = meta.info(episodes=len(self._rows), frames=self._frames, **sizes)
        stats = {k: meta.statistics(np.concatenate(v)) for k, v in self._columns.items()}
        stats[meta.IMAGE] = meta.image_statistics(np.concatenate(self._seen))
        schema = meta.tasks_schema(self._arrow)
        tasks = self._arrow.table([[0], [self._task]], schema=schema)
        episodes = self._arrow.Table.from_pylist(self._rows)
        for table, name in ((tasks, meta.TASKS), (episodes, meta.EPISODES)):
            self._parquet.write_table(table, self._path(name))
        for name, content in (("info", told), ("stats", stats)):
            self._path(f"meta/{name}.json").write_text(json.dumps(content, indent=2))

    def _table(self, episode: Episode, number: int) -> dict[str, NDArray[Any]]:
        """Return all columns, each (n, k)."""
        count = np.arange(len(episode))[:, None]
        vectors = (episode.state, episode.action, episode.uncertainty)
        return {
            **dict(zip(meta.VECTORS, vectors, strict=True)),
            meta.TIME: episode.stamp_us[:, None] * 1e-6,
            "timestamp": (count / self._rate_hz).astype(np.float32),
            "frame_index": count,
            "episode_index": np.full_like(count, number),
            "index": count + self._frames,
            "task_index": np.zeros_like(count),
        }

    def _write_table(self, columns: dict[str, NDArray[Any]], name: str) -> None:
        arrays = {
            key: values[:, 0] if values.shape[1] == 1 else list(values)
            for key, values in columns.items()
        }
        self._parquet.write_table(self._arrow.table(arrays), self._path(name))

    def _write_film(self, images: Rgb, number: int) -> None:
        names = {"video_key": meta.IMAGE, "chunk_index": 0, "file_index": number}
        with self._av.open(str(self._path(meta.VIDEO.format(**names))), "w") as film:
            stream = film.add_stream(CODEC, rate=self._rate_hz, options=LOSSLESS_ENOUGH)
            stream.height, stream.width = images.shape[1:3]
            stream.pix_fmt = "yuv420p"
            for place, rgb in enumerate(images):
                picture = self._av.VideoFrame.from_ndarray(rgb, format="rgb24")
                picture.pts, picture.time_base = place, Fraction(1, self._rate_hz)
                film.mux(stream.encode(picture))
            film.mux(stream.encode(None))

    def _row(self, number: int, length: int) -> meta.Json:
        film = f"videos/{meta.IMAGE}"
        return {
            "episode_index": number,
            "tasks": [self._task],
            "length": length,
            "data/chunk_index": 0,
            "data/file_index": number,
            "dataset_from_index": self._frames,
            "dataset_to_index": self._frames + length,
            f"{film}/chunk_index": 0,
            f"{film}/file_index": number,
            f"{film}/from_timestamp": 0.0,
            f"{film}/to_timestamp": length / self._rate_hz,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }

    def _path(self, name: str) -> Path:
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


def write_lerobot(episodes: Sequence[Episode], folder: Path, task: str) -> None:
    """Write a dataset of these flights; raises LogFileError."""
    writer = DatasetWriter(folder, task)
    for episode in episodes:
        writer.add(episode)
    writer.close()


def _image(path: Path) -> Rgb:
    bgr = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if bgr is None:
        raise LogFileError(f"{path} is no image: the disk was full, or it was cut; remove it")
    return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), dtype=np.uint8)
