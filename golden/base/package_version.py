"""The version of this package: of an installed one fixed, of a checkout that of its commit."""

import subprocess
from importlib.metadata import version
from pathlib import Path

__all__ = ["DISTRIBUTION", "package_version"]

DISTRIBUTION = "radiosity-engine"
"""Its name."""


def package_version(root: Path = Path(__file__).parents[2]) -> str:
    """The version, of the form that Python's packages have.

    In a checkout it is read from git at each call: the last tag (without one the version of the installed metadata),
    then, unless the commit is the tagged one and nothing is changed, ``+``, the commits since the tag, ``g`` and the
    commit, and ``dirty`` if files are changed: ``0.2.0+5.g1234abc.dirty``. Elsewhere, and where git cannot be run, it
    is that of the installed metadata.

    Parameters
    ----------
    root
        The folder that has the packages.
    """
    installed = version(DISTRIBUTION)
    if not (root / ".git").exists():
        return installed
    try:
        described = subprocess.run(["git", "-C", root, "describe", "--tags", "--long", "--always", "--dirty", "--match",
                                    "[v0-9]*"], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return installed
    described, dirty, _ = described.partition("-dirty")
    tag, since, commit = ([None, None, *described.rsplit("-", 2)])[-3:]
    if tag is None:
        return ".".join([f"{installed}+g{commit}", *["dirty"] * bool(dirty)])
    tag = tag.removeprefix("v")
    return tag if since == "0" and not dirty else ".".join([f"{tag}+{since}", commit, *["dirty"] * bool(dirty)])
