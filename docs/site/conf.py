"""How Sphinx makes the site of docs/: `scripts/pages/site` calls it. It asks no network."""

import re
from pathlib import Path
from typing import Any

from pygments.lexers.special import TextLexer
from sphinx.highlighting import lexers

from flightstack import __version__

DOCS = Path(__file__).resolve().parents[1]
PICTURE = re.compile(r"!\[[^]]*\]\(([^)]+)\)")
lexers["mermaid"] = TextLexer()  # the diagram of states stays the text that it is

project, author = "flightstack", "the flightstack authors"
project_copyright = "the flightstack authors, BSD-3-Clause"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["examples/**/*.egg-info", "site"]
suppress_warnings = ["config.cache"]
default_role = "code"  # single backticks of docstrings

myst_heading_anchors = 4  # links such as logs.md#checks
myst_enable_extensions = ["colon_fence", "deflist"]
myst_links_external_new_tab = False

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
add_module_names = False
python_use_unqualified_type_names = True

html_theme = "furo"
html_title = f"flightstack {__version__}"
html_show_sphinx = False
html_copy_source = False
html_last_updated_fmt = None  # the same text gives the same pages


def leave_out_missing_pictures(_: Any, name: str, source: list[str]) -> None:
    """Show a table of results without the pictures that its folder in docs/results/ left out."""
    if name.startswith("results/"):
        folder = (DOCS / name).parent
        source[0] = PICTURE.sub(
            lambda picture: picture[0] if (folder / picture[1]).is_file() else "", source[0]
        )


def setup(app: Any) -> None:
    """Tell Sphinx."""
    app.connect("source-read", leave_out_missing_pictures)
