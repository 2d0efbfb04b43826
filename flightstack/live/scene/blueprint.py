"""How the view is laid out: image and texts at the left, the course, and lines over time."""

from typing import Any

from flightstack.libraries import load_library
from flightstack.live.scene.recording import EXTRA, TIMELINE

EYE, TARGET, UP = (-15.0, -3.0, -14.0), (1.5, 7.5, 0.0), (0.0, 0.0, -1.0)  # north, east, down, m


def make_blueprint() -> Any:
    """Return rerun's description of the layout."""
    views = load_library("rerun.blueprint", EXTRA)
    plots = [
        views.TimeSeriesView(origin=f"/velocity/{name}", name=title)
        for name, title in (
            ("forward", "forward, m/s"),
            ("right", "right, m/s"),
            ("down", "down, m/s"),
            ("yaw_rate", "yaw rate, rad/s"),
        )
    ]
    doubts = views.TimeSeriesView(origin="/uncertainty", name="uncertainty, m/s")
    course = views.Spatial3DView(
        origin="/world",
        name="course, path, gates seen",
        eye_controls=views.EyeControls3D(position=EYE, look_target=TARGET, eye_up=UP),
        overrides={"/world/path": _all_so_far(views)},
    )
    seen = views.Spatial2DView(origin="/camera", name="camera")
    texts = views.TextLogView(origin="/texts", name="modes and texts")
    return views.Blueprint(
        views.Horizontal(
            views.Vertical(seen, texts, row_shares=[3, 2]),
            course,
            views.Vertical(*plots, doubts),
            column_shares=[2, 3, 3],
        ),
        views.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following"),
        views.SelectionPanel(state="hidden"),
        views.BlueprintPanel(state="hidden"),
        collapse_panels=True,
    )


def _all_so_far(views: Any) -> Any:
    """Return the override by which the path grows: all of it from the start to the moment."""
    boundary = views.TimeRangeBoundary
    return views.VisibleTimeRanges(
        timeline=TIMELINE, start=boundary.infinite(), end=boundary.cursor_relative()
    )
