"""The page that shows the viewer: served by us, or one file with all in it that opens offline.

Its content security policy lets it load from where it came and from nowhere else: rerun's own page
calls servers of analytics, fonts and versions, and so would the viewer itself.
"""

import base64
import gzip
from importlib.resources import files

from flightstack.live.viewer.files import SCRIPT, ViewerFiles

COMMON = "default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data: blob:; "
SERVED = COMMON + "script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; connect-src 'self'"
OFFLINE = COMMON + "script-src 'unsafe-inline' 'wasm-unsafe-eval'; connect-src 'none'"


def served_page() -> bytes:
    """Return the page whose script, WASM and recording stand beside it."""
    return _filled(SERVED, f'<script src="{SCRIPT}"></script>', "")


def offline_page(viewer: ViewerFiles, recording: bytes) -> bytes:
    """Return a page that needs nothing else: viewer and recording are inside."""
    script = viewer.script.decode().replace("</script", "<\\/script")
    data = {"wasm": viewer.wasm_gzip, "recording": gzip.compress(recording, mtime=0)}
    blocks = "".join(
        f'<script type="text/plain" id="{name}">{base64.b64encode(content).decode()}</script>\n'
        for name, content in data.items()
    )
    return _filled(OFFLINE, f"<script>{script}</script>", blocks)


def _filled(policy: str, script: str, data: str) -> bytes:
    page = files(__package__).joinpath("page.html").read_text()
    for name, value in (("POLICY", policy), ("DATA", data), ("SCRIPT", script)):
        page = page.replace(f"${name}", value, 1)
    return page.encode()
