"""What is made of the bytes that a board has sent."""

import random
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from golden.base.errors import InputError
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR, load_descriptor
from golden.engine.jobs.result_formats import FULL_HIT, HitFormat
from hw.board.frame import FrameKind, header
from hw.registers.error_code import ErrorCode
from radiosity.flow.host import EngineError
from tb.board.decoder import Frame, encode, frames, hit_picture, results
from tb.board.picture import main


def cast(cycles, patches, *, error=ErrorCode.NONE):
    """The frames of a cast of 3 x 2 rays, of a load and a section."""
    descriptors, completions = np.zeros(2, DESCRIPTOR.dtype), np.zeros(4, COMPLETION.dtype)
    descriptors[0] = load_descriptor(0, 1, tag=0)
    descriptors["tag"], descriptors["columns"], descriptors["rows"] = (0, 1), (0, 3), (0, 2)
    descriptors["hit_format"] = HitFormat.FULL
    completions["tag"][:2], completions["cluster"] = (0, 1), 3
    # The cycle counter has overflowed in between.
    completions["begin"][:2], completions["end"][:2] = (7, (1 << 32) - 50), (9, cycles - 50)
    completions["error"][1], completions["address"][1] = error.value, 0x1234567890
    hits = np.zeros(6, FULL_HIT.dtype)
    hits["patch"], hits["inverse"] = patches, 5
    return [Frame(FrameKind.COMPLETIONS, completions.tobytes()), Frame(FrameKind.DESCRIPTORS, descriptors.tobytes()),
            Frame(FrameKind.HITS, hits.tobytes())]


ERROR = Frame(FrameKind.ERROR, ErrorCode.WATCHDOG.value.to_bytes(4, "little") + bytes([2, 0, 0, 0]) + (
    0x1234567890).to_bytes(8, "little"))
FIRST, SECOND = cast(100, range(6)), cast(200, [0, -1, 0, 2, 2, -1])


def test_frames_are_found_among_other_bytes():
    chance, data = random.Random(2), bytearray(b"RAD")
    for frame in FIRST:
        data += chance.randbytes(20) + encode(frame)
    assert frames(bytes(data)) == FIRST
    # One that has been spoilt, a piece of one, and one that has not ended.
    spoilt = bytearray(encode(FIRST[1]))
    spoilt[30] ^= 4
    unknown = bytearray(header(FrameKind.HITS, 0).to_bytes(8, "little"))
    unknown[4] = 7
    unknown += zlib.crc32(unknown).to_bytes(4, "little")
    found = frames(bytes(spoilt + unknown) + encode(FIRST[2])[:50] + encode(FIRST[0]) + encode(FIRST[2])[:-1])
    assert found == FIRST[:1]


def test_the_last_cast_counts():
    found = results(FIRST + SECOND)
    assert (found.cycles, found.columns, found.rows) == (200, 3, 2)
    assert found.hits.patch.tolist() == [0, -1, 0, 2, 2, -1]
    assert found.hits.inverse.tolist() == [5] * 6
    assert found.completions["tag"].tolist() == [0, 1]
    picture = hit_picture(found)
    assert picture.shape == (2, 3, 3)
    assert (picture[0, 0] == picture[0, 2]).all()
    assert (picture[0, 0] != picture[1, 0]).any()
    assert (picture[[0, 1], [1, 2]] == 0).all()


def test_errors():
    with pytest.raises(EngineError, match="WATCHDOG") as raised:
        results([*FIRST, ERROR])
    assert (raised.value.cluster, raised.value.address) == (2, 0x1234567890)
    with pytest.raises(EngineError, match="PATH_PATCH") as raised:
        results([*FIRST, *cast(200, [0] * 6, error=ErrorCode.PATH_PATCH)])
    assert (raised.value.cluster, raised.value.address) == (3, 0x1234567890)
    with pytest.raises(InputError, match=r"no frame of hits$"):
        results([*FIRST, *SECOND[:2]])
    with pytest.raises(InputError, match=r"no frame of completions, descriptors, hits$"):
        results([])
    with pytest.raises(ValueError, match="Length must be from 0 to 16777215"):
        header(FrameKind.HITS, 1 << 24)


def test_the_page_has_all_kinds():
    page = (Path(__file__).parents[2] / "docs" / "board.md").read_text()
    kinds = [int(kind, 16) for kind in re.findall(r"^\| (0x[0-9a-f]{2}) \| .* \|$", page, re.MULTILINE)]
    assert kinds == [one.value for one in FrameKind]


def test_picture(tmp_path):
    given, output = tmp_path / "sent.bin", tmp_path / "hits.png"
    given.write_bytes(b"".join(map(encode, SECOND)))
    done = CliRunner().invoke(main, [str(given), "-o", str(output)])
    assert done.exit_code == 0, done.output
    assert "6 rays, 4 hits, 200 cycles" in done.output
    with Image.open(output) as picture:
        assert (np.asarray(picture) == hit_picture(results(SECOND))).all()
    given.write_bytes(encode(ERROR))
    done = CliRunner().invoke(main, [str(given), "-o", str(output)])
    assert done.exit_code
    assert "WATCHDOG" in done.output
