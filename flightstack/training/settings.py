"""Records of settings, as what is made from them names them."""

from dataclasses import asdict, fields
from typing import Any

ADDED_LATER = "added later"  # metadata of a field, see named_settings


def named_settings(settings: Any) -> dict[str, Any]:
    """Name the settings of a dataclass, those added later only where they are not default.

    So what was made before there was such a field is still known as made from the same settings.
    """
    default = {
        field.name
        for field in fields(settings)
        if ADDED_LATER in field.metadata and getattr(settings, field.name) == field.default
    }
    return {name: value for name, value in asdict(settings).items() if name not in default}
