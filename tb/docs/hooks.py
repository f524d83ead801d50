"""What the site has beside the pages of docs/: the front page, and the pages made from the code."""

import re
from pathlib import Path

from mkdocs.structure.files import File

from tb.docs.contents import Contents

ROOT = Path(__file__).parents[2]
# Files outside docs/, by their names on the site.
OUTSIDE = {"index.md": "README.md", "changelog.md": "CHANGELOG.md", "contributing.md": "CONTRIBUTING.md",
           "CITATION.cff": "CITATION.cff"}


def on_config(config):
    """Look at the code; the reference is the last part of the navigation."""
    contents = config["contents"] = Contents()
    config.nav.append({"Reference": contents.navigation()})
    return config


def on_files(files, *, config):
    """Pages that are made."""
    for path, text in config["contents"].pages().items():
        files.append(File.generated(config, path, content=text))
    for path, source in OUTSIDE.items():
        text = (ROOT / source).read_text()
        for other, outside in OUTSIDE.items():
            text = text.replace(f"]({outside})", f"]({other})")
        files.append(File.generated(config, path, content=re.sub(r"\]\(docs/", "](", text)))
    return files


def on_page_markdown(markdown, *, page, config, files):
    """Parts of pages that are made."""
    return config["contents"].complete(markdown, page.file.src_uri)
