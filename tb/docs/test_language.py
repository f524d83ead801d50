"""Pages, comments, docstrings and messages use the field's words: tb/docs/words.md."""

import re
from functools import cache

import pytest

from tb.docs.language import (
    ROOT,
    as_words,
    forbidden_phrases,
    markdown_files,
    occurrences,
    prose_of_markdown,
    prose_of_python,
    replacements,
    words_of_names,
)

# Whatever tests of the lint itself have to say.
OWN = {"tb/docs/test_language.py", "tb/docs/test_sentences.py"}

CODE = [path for folder in ("benchmarks", "golden", "hw", "radiosity", "tb") for suffix in ("py", "cpp", "h", "v")
        for path in sorted((ROOT / folder).rglob(f"*.{suffix}"))]
FILES = [path for path in (*markdown_files(), ROOT / "Makefile", ROOT / "pyproject.toml", ROOT / "mkdocs.yml", *CODE)
         if str(path.relative_to(ROOT)) not in OWN]


def test_no_private_words_are_left():
    pattern = forbidden_phrases()
    found = [hit for path in FILES for hit in occurrences(path, pattern)]
    assert not found, "tb/docs/words.md names the field's words:\n" + "\n".join(found)


def test_names_have_no_private_words():
    pattern = forbidden_phrases()
    search = cache(lambda name: pattern.search(as_words(name)))
    found = sorted({f"{path.relative_to(ROOT)}:{line}: {words}" for path in CODE if path.suffix == ".py"
                    # What is in no name, comment or string needs no tokens.
                    if any(map(search, re.findall(r"[^\W\d]\w*", path.read_text())))
                    for line, words in words_of_names(path.read_text()) if search(words)})
    assert not found, "tb/docs/words.md names the field's words:\n" + "\n".join(found)


def test_docstrings_name_what_they_raise():
    found = [str(path.relative_to(ROOT)) for path in CODE if path.suffix == ".py"
             if re.search(r"\n *Errors\n *------\n", path.read_text())]
    assert not found, f"'Raises' instead of 'Errors': {', '.join(found)}"


def test_the_list_names_what_replaces_each_phrase():
    table = replacements()
    assert len(table) > 40
    assert all(right.strip() for right in table.values())


@pytest.mark.parametrize("text", ["requests under way", "Under\nway", "the slowest ways.", "'somebody else's RAM'"])
def test_a_phrase_is_found_across_lines_and_in_any_case(text):
    assert forbidden_phrases().search(text)


@pytest.mark.parametrize("text", ["four-way LRU", "a cache way", "the next item", "thunder wayside", "alongside"])
def test_other_words_are_no_false_alarm(text):
    assert not forbidden_phrases().search(text)


def test_names_are_read_as_words():
    assert words_of_names("_under_way = IsAsked") == [(1, "under way"), (1, "Is Asked")]
    assert forbidden_phrases().search("Is Asked")
    assert not forbidden_phrases().search("masked")


def test_only_comments_and_strings_of_code_are_read():
    text = 'under_way = 1  # now\n# two\n# lines\nx = f"{under_way} left"\n'
    prose = prose_of_python(text)
    assert (1, "now\ntwo\nlines") in prose
    assert not any("under_way =" in part for _, part in prose)


def test_code_and_targets_of_pages_are_not_read():
    text = "See [a page](under-way.md), `knob` and\n\n```sh\nknob\n```\n<!-- knob -->\nend\n"
    assert prose_of_markdown(text).split() == ["See", "a", "page,", "and", "end"]
    assert prose_of_markdown(text).count("\n") == text.count("\n")
