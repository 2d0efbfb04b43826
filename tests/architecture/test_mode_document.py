"""The document of the wire has the table of modes that the autopilot goes by."""

from sitl.autopilot.command.mode_table import (
    MODES,
    OFFBOARD_BY_ATTITUDE,
    Acceptance,
    ModeRules,
    Needs,
)
from tests.paths import DOCS

COLUMNS = (
    "mode",
    "led by",
    "armed in",
    "chosen in flight",
    "needs",
    "falls back to",
    "COM_RC_OVERRIDE",
    "COM_RCL_EXCEPT",
)
CHOSEN = {
    Acceptance.WITH_ITS_NEEDS: "with its needs",
    Acceptance.ALWAYS: "always",
    Acceptance.NEVER: "never",
}


def line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |".replace("  ", " ")


def row(rules: ModeRules, remark: str = "") -> str:
    return line(
        rules.name + remark,
        rules.leader.value,
        "yes" if rules.armable else "",
        CHOSEN[rules.accepted],
        ", ".join(name for name in Needs._fields if getattr(rules.needs, name)),
        ", ".join(action.name.lower() for action in rules.falls_back_to),
        str(rules.override_bit or ""),
        str(rules.exception_bit or ""),
    )


def table() -> str:
    rows = [row(rules) for rules in MODES.values()]
    rows.append(row(OFFBOARD_BY_ATTITUDE, " by attitude or rates"))
    return "\n".join([line(*COLUMNS), "|---" * len(COLUMNS) + "|", *rows])


def test_every_mode_is_documented_as_it_is() -> None:
    document = (DOCS / "wire.md").read_text()
    assert table() in document, f"docs/wire.md, Modes, should have\n\n{table()}"
