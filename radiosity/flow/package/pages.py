"""Pages beside an exported engine: registers, and formats in main memory."""

import re
import textwrap

from golden.engine.jobs.job_tables import job_tables
from golden.engine.jobs.result_formats import FULL_HIT
from golden.engine.memory_map.layout_tables import layout_tables, record_table
from radiosity.flow.package.registers_page import page

__all__ = ["core_pages"]

_FORMATS = """\
# Formats in main memory

* Integers are little-endian: u1, u2, u4, u8 unsigned and i4 signed, of that many bytes.
* The rings, images, hits and sums begin at multiples of 64 bytes, the cells of shell 1 at a multiple of 8.
* The hit of ray (column, row) is record row x columns + column from `hits` of the descriptor on. Format 1 is the record
  `hit` below. Format 2 has 8 bytes: the inverse distance in bits 0-23, the patch in 24-47, u in 48-55, v in 56-63; all
  ones in the patch are no hit. Format 3 has the patch alone, a u4; all ones are no hit.
* A shadow frustum (`bundle` 2) has a list of rays, a u8 each: the slope x + 1 in units of 2^-16 in bits 0-16, y + 1 in
  20-36, its end, a stored inverse distance, in 40-63. From `hits` on bit k modulo 64 of the u8 number k / 64 says that
  ray k of the list is blocked: a patch is before its end.
* A word of sums has 64 bits: the sum in bits 0-41, the patch in 42-63. The completion record has the number of words.
* Completion record k is in entry k modulo 2^`ring_bits` of its ring, whatever the order of the descriptors.

## What results mean

* A stored inverse distance n of more than 0 is (1 + f 2^-F) 2^(e - B), where f is n modulo 2^F and e is n divided by
  2^F, rounded down; the manifest has F and B (`results.inverse`), and so has `job.h`. Its reciprocal times
  `RADIOSITY_JOB_UNIT` is the distance of the hit in units of the scene, of a screen the depth along its view. The
  largest n is this near or nearer, n = 1 is a patch that the ray sees edge-on.
* Column k of a hemisphere has the azimuth (k + 1/2) 2 pi / columns, row k the angle (k + 1/2) (pi / 2) / rows from the
  normal. Column k of a screen is at x = (2 k + 1 - columns) / 2^`column_bits`, row k, downwards, at
  y = (2 k + 1 - rows) / 2^`row_bits`. `columns` and `rows` of an image have the cosines and sines, or these numbers.
* Step k of u or of v is the part of the patch from k 2^-U to (k + 1) 2^-U; U is `results.uv_bits` of the manifest. u
  is 0 at the edge of vertices 3 and 0 and 1 at that of 1 and 2; v is 0 at the edge of 0 and 1 and 1 at that of 2 and 3.
  The patch is bisected around the ray, in each step in u first and then in v.
* A sum divided by the sum of all weights of a hemisphere, 2^`RADIOSITY_JOB_WEIGHT_BITS`, is the form factor of the
  patch.
* The `address` in the record of a refused descriptor is no address: it is the offset of the field in the descriptor.

`example/decode.c` and `example/decode.py` decode the lines of `job.txt`.

## Jobs

{jobs}
{hit}
## Memory images

{images}"""


def core_pages() -> dict[str, str]:
    """The pages as Markdown by the names of their files."""
    pages = {"registers.md": page(),
             "formats.md": _FORMATS.format(jobs=job_tables(), hit=record_table(FULL_HIT), images=layout_tables())}
    return {name: _with_links("\n\n".join(map(_for_export, text.split("\n\n")))) for name, text in pages.items()}


def _for_export(paragraph):
    """A paragraph without sentences about the project's sources and about pages that are not exported."""
    sentences = re.split(r"(?<=\.)\s+", paragraph)
    kept = [one for one in sentences if not re.search(r"\]\(\.\./engine\.md|`(?:hw/|python -m hw )", one)]
    if paragraph.startswith("|") or len(kept) == len(sentences):
        return paragraph
    return textwrap.fill(" ".join(kept), width=120)


def _with_links(text):
    """A page whose links to formats lead to the one beside it; of other pages of the documentation the text stays."""
    text = re.sub(r"\]\(\.\./(?:memory-map|job-format)\.md\)", "](formats.md)", text)
    return re.sub(r"\[([^]]*)\]\((?!https:|formats\.md)[^)]*\)", r"\1", text)
