"""Name what a user may have meant."""

from collections.abc import Iterable


def did_you_mean(wrong: str, right: Iterable[str]) -> str:
    """Return "; did you mean A or B?", or "" where nothing comes near."""
    from difflib import get_close_matches  # noqa: PLC0415  # only where somebody erred

    candidates = list(right)
    near = get_close_matches(wrong, candidates, n=3, cutoff=0.6)
    if not near:
        folded = {name.lower(): name for name in candidates}
        close = get_close_matches(wrong.lower(), folded, n=3, cutoff=0.6)
        near = [folded[name] for name in close]
    return f"; did you mean {' or '.join(near)}?" if near else ""
