"""Manifests of cores without the hardware that they are exported from."""

import json
from pathlib import Path

from golden.engine.config import Config
from golden.engine.jobs.descriptor import VERSION as DESCRIPTOR_VERSION
from golden.engine.memory_map import VERSION as IMAGE_VERSION

__all__ = ["write_manifest"]


def write_manifest(path: Path, config: Config, **changes) -> Path:
    """Write what `golden.engine.jobs.core_manifest` reads, with other values of the keys given;
    `tb.radiosity.flow.package.test_manifest` compares it with an exported one.
    """
    facts = {"parameters": config.parameters(), "policies": {"direct": 0, "lru": 1, "lfu": 2}, "sha256": "0123",
             "formats": {"image": {"version": IMAGE_VERSION}, "descriptor": {"version": DESCRIPTOR_VERSION}}}
    path.write_text(json.dumps(facts | changes))
    return path
