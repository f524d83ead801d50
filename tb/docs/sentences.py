"""Draws sentences of the documentation: ``python -m tb.docs.sentences --seed 1``."""

import random
import re

import click

from tb.docs.language import ROOT, forbidden_phrases, markdown_files, prose_of_markdown

__all__ = ["main", "sample", "sentences"]


def sentences(text: str) -> list[str]:
    """The sentences of a page: of paragraphs and items of lists, not of headings and tables."""
    found = []
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[*-]|\d+\.) )", prose_of_markdown(text, spans=True)):
        lines = [line.strip() for line in block.splitlines() if not line.lstrip().startswith(("|", "#"))]
        words = re.sub(r"^(?:[*-]|\d+\.) ", "", re.sub(r"\*+", "", " ".join(filter(None, lines))))
        found += [part.strip() for part in re.split(r"(?<=[.!?:])\s+(?=[A-Z(])", words) if len(part.split()) > 3]
    return found


def sample(seed: int, count: int = 40) -> list[tuple[str, str]]:
    """``count`` sentences of README and docs, drawn with a seed, each with its page."""
    everything = [(str(page.relative_to(ROOT)), sentence) for page in markdown_files()
                  for sentence in sentences(page.read_text())]
    return random.Random(seed).sample(everything, count)


@click.command()
@click.option("--seed", default=1, show_default=True, help="Seed of the draw.")
@click.option("--count", default=40, show_default=True, help="How many sentences to draw.")
def main(seed: int, count: int) -> None:
    """Print sentences of the documentation, and fail if one has a phrase that tb/docs/words.md forbids."""
    pattern = forbidden_phrases()
    drawn = sample(seed, count)
    for page, sentence in drawn:
        click.echo(f"{page}: {sentence}")
    bad = [sentence for _, sentence in drawn if pattern.search(sentence)]
    click.echo(f"seed {seed}: {len(drawn)} sentences, {len(bad)} with a word that tb/docs/words.md forbids")
    raise SystemExit(bool(bad))


if __name__ == "__main__":
    main()
