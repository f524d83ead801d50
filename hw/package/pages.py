"""Pages beside an exported engine: registers, and formats in main memory."""

import re
import textwrap
from collections.abc import Mapping

from golden.jobs.job_tables import job_tables
from golden.jobs.result_formats import FULL_HIT
from golden.memory_map.layout_tables import layout_tables, record_table
from hw.registers.page import page

__all__ = ["core_pages"]

_FORMATS = """\
# Formats in main memory

* Integers are little-endian: u1, u2, u4, u8 unsigned and i4 signed, of that many bytes.
* The rings, images, hits and sums begin at multiples of 64 bytes, the cells of shell 1 at a multiple of 8.
* The hit of ray (column, row) is record row x columns + column from `hits` of the descriptor on. Format 1 is the record
  `hit` below. Format 2 has 8 bytes: the inverse distance in bits 0-23, the patch in 24-47, u in 48-55, v in 56-63; all
  ones in the patch are no hit. Format 3 has the patch alone, a u4; all ones are no hit.
* A word of sums has 64 bits: the sum in bits 0-41, the patch in 42-63. The completion record has the number of words.
* Completion record k is in entry k modulo 2^`ring_bits` of its ring, whatever the order of the descriptors.

## Jobs

{jobs}
{hit}
## Memory images

{images}"""


def core_pages(counters: Mapping[str, str]) -> dict[str, str]:
    """The pages as Markdown by the names of their files.

    Parameters
    ----------
    counters
        Names of the counters of a cluster in the order of their addresses, each with what it counts.
    """
    pages = {"registers.md": page(counters),
             "formats.md": _FORMATS.format(jobs=job_tables(), hit=record_table(FULL_HIT), images=layout_tables())}
    return {name: _with_links("\n\n".join(map(_for_export, text.split("\n\n")))) for name, text in pages.items()}


def _for_export(paragraph):
    """A paragraph without sentences about the project's sources and about pages that are not exported."""
    sentences = re.split(r"(?<=\.)\s+", paragraph)
    kept = [one for one in sentences if not re.search(r"\]\((?:engine|verilog)\.md|`(?:hw/|python -m hw )", one)]
    if paragraph.startswith("|") or len(kept) == len(sentences):
        return paragraph
    return textwrap.fill(" ".join(kept), width=120)


def _with_links(text):
    """A page whose links to formats lead to the one beside it; of other pages of the documentation the text stays."""
    text = re.sub(r"\]\((?:memory-map|job-format)\.md\)", "](formats.md)", text)
    return re.sub(r"\[([^]]*)\]\((?!https:|formats\.md)[^)]*\)", r"\1", text)
