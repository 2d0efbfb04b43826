"""What a LeRobot dataset of format v3.0 says of itself: features, statistics, episodes, tasks."""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.export.episode import ACTION, STATE, UNCERTAINTY

VERSION = "v3.0"
IMAGE, TIME = "observation.images.front", "observation.vehicle_time"
VECTORS = {"observation.state": STATE, "action": ACTION, "uncertainty": UNCERTAINTY}
INDICES = ("frame_index", "episode_index", "index", "task_index")
DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
EPISODES, TASKS = "meta/episodes/chunk-000/file-000.parquet", "meta/tasks.parquet"

Json = dict[str, Any]


def info(*, episodes: int, frames: int, rate_hz: int, height: int, width: int) -> Json:
    """Return meta/info.json."""
    features: Json = {
        IMAGE: {
            "dtype": "video",
            "shape": [height, width, 3],
            "names": ["height", "width", "channels"],
            "info": {"video.fps": rate_hz, "video.codec": "h264", "video.pix_fmt": "yuv420p"},
        },
        **{
            key: {"dtype": "float32", "shape": [len(names)], "names": list(names)}
            for key, names in VECTORS.items()
        },
        TIME: {"dtype": "float64", "shape": [1], "names": None},
        "timestamp": {"dtype": "float32", "shape": [1], "names": None},
        **{key: {"dtype": "int64", "shape": [1], "names": None} for key in INDICES},
    }
    return {
        "codebase_version": VERSION,
        "robot_type": "quadrotor",
        "total_episodes": episodes,
        "total_frames": frames,
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": rate_hz,
        "splits": {"train": f"0:{episodes}"},
        "data_path": DATA,
        "video_path": VIDEO,
        "features": features,
    }


def statistics(values: NDArray[Any]) -> dict[str, list[Any]]:
    """Return least, greatest, mean, standard deviation and count of rows (n, k)."""
    rows = values.astype(np.float64)
    return {
        "min": rows.min(axis=0).tolist(),
        "max": rows.max(axis=0).tolist(),
        "mean": rows.mean(axis=0).tolist(),
        "std": rows.std(axis=0).tolist(),
        "count": [len(rows)],
    }


def image_statistics(rgb: NDArray[np.uint8]) -> dict[str, list[Any]]:
    """Return the same of images (n, H, W, 3), per channel of 0 to 1, (3, 1, 1)."""
    told = statistics(rgb.reshape(-1, 3) / 255.0)
    shaped = {key: [[[value]] for value in told[key]] for key in ("min", "max", "mean", "std")}
    return {**shaped, "count": [len(rgb)]}


def tasks_schema(arrow: Any) -> Any:
    """Return the schema of the table of tasks, whose index is the text: pandas wants it told."""
    index = "__index_level_0__"
    column: Json = {"metadata": None}
    text = {"name": None, "field_name": index, "pandas_type": "unicode", "numpy_type": "object"}
    number = {"name": "task_index", "field_name": "task_index"}
    number |= {"pandas_type": "int64", "numpy_type": "int64"}
    told = {
        "index_columns": [index],
        "column_indexes": [],
        "columns": [column | number, column | text],
        "pandas_version": "2.0.0",
    }
    fields = [("task_index", arrow.int64()), (index, arrow.string())]
    return arrow.schema(fields, metadata={"pandas": json.dumps(told)})
