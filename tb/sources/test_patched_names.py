"""What tests put something else in place of, named in a string: it exists, so that a module moves with its tests."""

import pkgutil
import re

from tb.sources.source_texts import source_texts

PATCHED = {(path, name) for path, text in source_texts("tb").items()
           for name in re.findall(r'setattr\(\s*"([a-z][\w.]*)"', text)}


def test_what_a_test_replaces_exists():
    assert not [(path, name) for path, name in sorted(PATCHED) if not exists(name)]


def test_patched_names_are_seen():
    assert len(PATCHED) >= 10
    assert exists("golden.cast.hemisphere.Hemisphere.polar_weights")
    assert not exists("golden.cast.hemisphere.Another")


def exists(name):
    try:
        pkgutil.resolve_name(name)
    except (AttributeError, ImportError):
        return False
    return True
