"""Links of a built site."""

from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

__all__ = ["broken_links"]


class _Page(HTMLParser):
    """Where a page links to, and what can be linked to in it."""

    def __init__(self, text):
        super().__init__()
        self.targets, self.anchors = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if value and name in ("href", "src", "xlink:href"):
                self.targets.append(value)
            elif value and name in ("id", "name"):
                self.anchors.add(value)


def broken_links(folder: Path) -> list[str]:
    """Links between the pages of a site to files, or to anchors in pages, that do not exist: page and link."""
    pages = {path.resolve(): _Page(path.read_text()) for path in sorted(folder.rglob("*.html"))
             # What a server shows for pages that are not there; it knows where the site begins.
             if path.name != "404.html"}
    return [f"{path.relative_to(folder.resolve())}: {target}"
            for path, page in pages.items() for target in _broken(path, page, pages)]


def _broken(path, page, pages) -> Iterator[str]:
    for target in page.targets:
        parts = urlsplit(target)
        if parts.scheme or parts.netloc:
            continue
        where = (path.parent / unquote(parts.path)).resolve() if parts.path else path
        where = where / "index.html" if where.is_dir() else where
        fragment = unquote(parts.fragment)
        if not where.exists() or (fragment and where in pages and fragment not in pages[where].anchors):
            yield target
