"""The document of the mission shows the tables that the companion walks."""

from scripts.draw_mission import DOCUMENT, drawn


def test_the_diagram_is_the_one_that_the_tables_give() -> None:
    written = DOCUMENT.read_text()
    assert "stateDiagram-v2" in written
    assert drawn(written) == written, "run scripts/draw_mission.py"
