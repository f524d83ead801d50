"""What is made of the bytes that a board has sent."""

import random
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from golden.errors import InputError
from golden.memory_map import REGIONS
from hw.board.frame import FrameKind, header, region_kind
from hw.host import EngineError
from hw.registers.error_code import ErrorCode
from tb.board.decoder import Frame, encode, frames, hit_picture, results
from tb.board.picture import main


def region(name, count, **fields):
    (layout,) = (one.dtype for one in REGIONS if one.name == name)
    records = np.zeros(count, layout)
    for field, value in fields.items():
        records[field] = value
    return Frame(region_kind(name), records.tobytes())


def cast(cycles, patches):
    return [Frame(FrameKind.CYCLES.value, cycles.to_bytes(4, "little")), region("frustum", 1, columns=3, rows=2),
            region("hits", 6, patch=patches), region("sums", 4, sum=[1, 2, 3, 1 << 40])]


ERROR = Frame(FrameKind.ERROR.value, ErrorCode.WATCHDOG.value.to_bytes(4, "little") + bytes([2, 0, 0, 0]) + (
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
    assert frames(bytes(spoilt) + encode(FIRST[2])[:50] + encode(FIRST[0]) + encode(FIRST[3])[:-1]) == FIRST[:1]


def test_the_last_cast_counts():
    cycles, regions = results(FIRST + SECOND)
    assert cycles == 200
    assert regions["sums"]["sum"].tolist() == [1, 2, 3, 1 << 40]
    picture = hit_picture(regions)
    assert picture.shape == (2, 3, 3)
    assert (picture[0, 0] == picture[0, 2]).all()
    assert (picture[0, 0] != picture[1, 0]).any()
    assert (picture[[0, 1], [1, 2]] == 0).all()


def test_errors():
    with pytest.raises(EngineError, match="WATCHDOG") as raised:
        results([*FIRST, ERROR])
    assert (raised.value.cluster, raised.value.address) == (2, 0x1234567890)
    with pytest.raises(InputError, match="no frame of hits, sums"):
        results([*FIRST, *SECOND[:2]])
    with pytest.raises(InputError, match="no frame of cycles, frustum, hits, sums"):
        results([])
    with pytest.raises(ValueError, match="Length must be from 0 to 16777215"):
        header(1, 1 << 24)


def test_the_page_has_all_kinds():
    page = (Path(__file__).parents[2] / "docs" / "board.md").read_text()
    kinds = {int(kind, 16): about for kind, about in re.findall(r"^\| (0x[0-9a-f]{2}) \| (.*) \|$", page, re.MULTILINE)}
    assert set(kinds) == {one.value for one in FrameKind} | {region_kind(name) for name in ("frustum", "hits", "sums")}
    for name in "frustum", "hits", "sums":
        assert f"`{name}`" in kinds[region_kind(name)]


def test_picture(tmp_path):
    given, output = tmp_path / "sent.bin", tmp_path / "hits.png"
    given.write_bytes(b"".join(map(encode, SECOND)))
    done = CliRunner().invoke(main, [str(given), "-o", str(output)])
    assert done.exit_code == 0, done.output
    assert "6 rays, 4 hits, 200 cycles" in done.output
    with Image.open(output) as picture:
        assert (np.asarray(picture) == hit_picture(results(SECOND)[1])).all()
    given.write_bytes(encode(ERROR))
    done = CliRunner().invoke(main, [str(given), "-o", str(output)])
    assert done.exit_code
    assert "WATCHDOG" in done.output
