"""Say in one line what the environment lacks, before anything of it is imported."""

from flightstack.libraries import require

LIBRARIES = ("gymnasium", "pybullet", "cloudpickle")


def check_installed() -> None:
    """Raise MissingLibraryError where a library is missing."""
    require("gym", *LIBRARIES)
