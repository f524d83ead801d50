"""The manifest of an exported core, as far as jobs for the core need it."""

import json
from dataclasses import dataclass
from pathlib import Path

from golden.base.errors import InputError
from golden.engine.config import PRESETS, Config
from golden.engine.jobs.descriptor import VERSION as DESCRIPTOR_VERSION
from golden.engine.memory_map.layout import VERSION as IMAGE_VERSION

__all__ = ["CoreManifest", "read_manifest"]

_VERSIONS = {"image": IMAGE_VERSION, "descriptor": DESCRIPTOR_VERSION}


@dataclass(frozen=True, kw_only=True)
class CoreManifest:
    """What jobs for a core follow from.

    Parameters
    ----------
    config
        The configuration.
    policy
        The number of its policy of caches, for the register ``policy``.
    sha256
        Of the core's Verilog.
    """

    config: Config
    policy: int
    sha256: str


def read_manifest(path: Path) -> CoreManifest:
    """The manifest of an engine that `radiosity verilog` has written.

    Raises
    ------
    InputError
        The file is no manifest of an engine, or of one whose formats in memory have other versions.
    OSError
        It cannot be read.
    """
    try:
        facts = json.loads(path.read_text())
        parameters, policies, sha256 = dict(facts["parameters"]), facts["policies"], str(facts["sha256"])
        versions = {name: facts["formats"][name]["version"] for name in _VERSIONS}
        numbers = {name: int(policies[name]) for name in ("direct", "lru", "lfu")}
    except (ValueError, TypeError, KeyError):
        raise InputError(f"manifest {str(path)!r}: it is no manifest of an engine, as `radiosity verilog` writes "
                         "it") from None
    for name, version in _VERSIONS.items():
        if versions[name] != version:
            raise InputError(f"manifest {str(path)!r}: Version of {name}s must be {version}, not {versions[name]}")
    base = PRESETS["paper"]
    if set(parameters) != set(base.parameters()):
        odd = ", ".join(sorted(set(parameters) ^ set(base.parameters())))
        raise InputError(f"manifest {str(path)!r}: Parameters must be those of this version; they differ in {odd}")
    try:
        config = base.replace(parameters)
    except TypeError as error:
        raise InputError(f"manifest {str(path)!r}: {error}") from None
    return CoreManifest(config=config, policy=numbers[config.memsys.cache_policy], sha256=sha256)
