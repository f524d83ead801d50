import re

import pytest

from golden.scene.builtin import BUILTIN
from tb.docs.language import ROOT

DOCS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


def test_gallery_shows_every_built_in_scene_with_its_patch_count():
    page = (ROOT / "docs" / "scenes.md").read_text()
    rows = re.findall(r"^\| !\[(\w+)\]\(pictures/(\w+)\.png\) \| `(\w+)` \| (\d+) \|", page, re.MULTILINE)
    assert [(*names, int(count)) for *names, count in rows] == [
        (name, name, name, len(scene.make())) for name, scene in BUILTIN.items()]


@pytest.mark.parametrize("page", DOCS, ids=lambda page: page.name)
def test_links_and_pictures_of_the_documentation_exist(page):
    targets = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text())
    assert not [target for target in targets if not (page.parent / target).exists()]
