"""Shards: parts of all tests that each end within a sitting."""

from dataclasses import dataclass
from pathlib import Path

__all__ = ["MINUTES", "READERS", "Shard", "shards"]

# A shard is ended after this many minutes.
MINUTES = 90
# Folders whose tests look for files, so that new ones concern them too.
READERS = {"benchmarks", "bugs", "docs", "packaging", "sources"}
# Folders whose tests take longer than a shard may, and the number of shards that they are cut into.
PARTS = {"docs": 2, "golden": 3, "memsys": 2, "radiosity": 7, "system": 4}


@dataclass(frozen=True)
class Shard:
    """Some files of tests.

    Parameters
    ----------
    name
        Its folder below ``tb``, and of several shards of a folder which one: ``system/2``.
    files
        Paths of test modules.
    """

    name: str
    files: tuple[Path, ...]


def shards(tb: Path, parts: dict[str, int] | None = None) -> list[Shard]:
    """All test modules below a folder, each in one shard: one for each folder, or several.

    Parameters
    ----------
    tb
        The folder of tests.
    parts
        Shards of the folders that have several; a shard has every so manyth file. Default: those of the project.
    """
    of_a_folder: dict[str, list[Path]] = {}
    for path in sorted(tb.rglob("test_*.py")):
        of_a_folder.setdefault(path.relative_to(tb).parts[0], []).append(path)
    found = []
    for name, files in of_a_folder.items():
        count = min((PARTS if parts is None else parts).get(name, 1), len(files))
        found += [Shard(name if count == 1 else f"{name}/{k + 1}", tuple(files[k::count])) for k in range(count)]
    return found
