"""Formats of results: nothing is lost, and memory is written where the results are and nowhere else."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.base.errors import InputError
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import PRESETS, Config
from golden.engine.ctu.sector import Sector
from golden.engine.icu.patch_sums import section_sums
from golden.engine.jobs.result_formats import (
    HitFormat,
    ResultCommand,
    check_config,
    pack_bits,
    pack_hits,
    pack_sums,
    result_beats,
    result_bytes,
    scatter_sums,
    section_rays,
    unpack_bits,
    unpack_hits,
    unpack_ids,
    unpack_sums,
)
from tb.golden.at_ends import at_ends
from tb.lib.schedules import SETTINGS

MISS = (0, -1, 0, 0)


def hits_of(rows):
    inverse, patch, u, v = np.array(rows, dtype=np.int64).reshape(-1, 4).T
    return FixedHits(inverse=inverse, patch=patch, u=u, v=v)


def drawn(inverse_bits, patch_bits, uv_bits):
    """Lists of hits and misses, with the extremes of every field."""
    return st.lists(st.just(MISS) | st.tuples(
        at_ends(1, (1 << inverse_bits) - 1), at_ends(0, (1 << patch_bits) - 2),
        at_ends(0, (1 << uv_bits) - 1), at_ends(0, (1 << uv_bits) - 1)), max_size=9).map(hits_of)


@pytest.mark.parametrize(("hit_format", "hits_of_its_widths"), [
    (HitFormat.FULL, drawn(31, 31, 12)), (HitFormat.COMPACT, drawn(24, 24, 8))], ids=["full", "compact"])
@SETTINGS
@given(data=st.data())
def test_hits_of_all_widths_return_bit_exact(hit_format, hits_of_its_widths, data):
    hits = data.draw(hits_of_its_widths)
    packed = pack_hits(hits, hit_format).tobytes()
    assert len(packed) == hit_format.bytes * len(hits.patch)
    back = unpack_hits(packed, hit_format)
    assert not len(back.differences(hits))
    assert all(getattr(back, name).dtype == np.int64 for name in ("inverse", "patch", "u", "v"))


@SETTINGS
@given(drawn(24, 31, 8))
def test_patches_return_from_ids(hits):
    assert np.array_equal(unpack_ids(pack_hits(hits, HitFormat.IDS).tobytes()), hits.patch)


@pytest.mark.parametrize(("rays", "words"), [(0, 1), (1, 1), (64, 1), (65, 2), (200, 4)])
def test_bits_of_a_list_return_from_words_of_which_the_first_ray_has_the_lowest_bit(rays, words):
    blocked = np.random.default_rng(rays).integers(2, size=rays).astype(bool)
    data = pack_bits(blocked)
    assert [word >> bit & 1 for word in struct.unpack(f"<{words}Q", data) for bit in range(64)] == (
        blocked.tolist() + [0] * (64 * words - rays))
    assert np.array_equal(unpack_bits(data, rays), blocked)


def test_bytes_of_hits_are_those_of_the_specification():
    hits = hits_of([(0x123456, 0x789ABC, 0xDE, 0xF0), MISS])
    assert pack_hits(hits, HitFormat.FULL).tobytes() == struct.pack(
        "<IiHHIIiHHI", 0x123456, 0x789ABC, 0xDE, 0xF0, 0, 0, -1, 0, 0, 0)
    assert pack_hits(hits, HitFormat.COMPACT).tobytes() == struct.pack("<QQ", 0xF0DE789ABC123456, 0x0000FFFFFF000000)
    assert pack_hits(hits, HitFormat.IDS).tobytes() == struct.pack("<II", 0x789ABC, 0xFFFFFFFF)
    assert pack_hits(hits, HitFormat.NONE).size == 0


@pytest.mark.parametrize(("row", "hit_format"), [
    ((1 << 24, 0, 0, 0), HitFormat.COMPACT), ((1, (1 << 24) - 1, 0, 0), HitFormat.COMPACT),
    ((1, 0, 256, 0), HitFormat.COMPACT), ((1, 0, 0, 256), HitFormat.COMPACT), ((1, -2, 0, 0), HitFormat.COMPACT),
    ((1, 0, 1 << 16, 0), HitFormat.FULL), ((1, -2, 0, 0), HitFormat.FULL), ((1, (1 << 32) - 1, 0, 0), HitFormat.IDS)])
def test_a_hit_that_would_lose_bits_is_refused(row, hit_format):
    with pytest.raises(InputError, match=r"results: .* must be"):
        pack_hits(hits_of([row]), hit_format)


def test_bytes_that_are_no_hits_are_refused():
    with pytest.raises(InputError, match="multiple of 8, not 12"):
        unpack_hits(bytes(12), HitFormat.COMPACT)
    with pytest.raises(InputError, match="16 or of 8 bytes"):
        unpack_hits(bytes(12), HitFormat.IDS)
    with pytest.raises(InputError, match="multiple of 4, not 10"):
        unpack_ids(bytes(10))


@pytest.mark.parametrize(("change", "hit_format", "sums", "message"), [
    ({}, HitFormat.COMPACT, True, None),
    ({"numbers.fraction_bits": 19}, HitFormat.COMPACT, False, "distances must have at most 24 bits .*8 bytes, not 25"),
    ({"icu.uv_bits": 9}, HitFormat.COMPACT, False, "U and v must have at most 8 bits"),
    ({"numbers.fraction_bits": 19, "icu.uv_bits": 9}, HitFormat.FULL, True, None),
    ({"icu.patch_bits": 24}, HitFormat.COMPACT, False, None),
    ({"icu.patch_bits": 22}, HitFormat.NONE, True, None),
    ({"icu.patch_bits": 23}, HitFormat.NONE, True, "Patch ids must have at most 22 bits in sums, not 23")])
def test_formats_that_a_configuration_does_not_fit_are_refused(change, hit_format, sums, message):
    config = Config().replace(change)
    if message is None:
        check_config(config, hit_format, sums=sums)
    else:
        with pytest.raises(InputError, match=message):
            check_config(config, hit_format, sums=sums)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_fit_all_formats(name):
    assert all(check_config(PRESETS[name], hit_format, sums=True) is None for hit_format in HitFormat)


RAYS = st.lists(st.tuples(st.integers(-1, 12), st.sampled_from([0, 1, 5, 1 << 40])), max_size=60)


@pytest.mark.parametrize(("last", "overflow"), [((1 << 40) - 1, -1), (1 << 40, 7), ((1 << 40) + 1, 7)])
def test_a_sum_overflows_at_its_word(last, overflow):
    sums = section_sums(np.array([3, 7, 7, 7, 7]), np.array([1, *[1 << 40] * 3, last]))
    assert sums.overflow == overflow
    if overflow < 0:
        assert unpack_sums(pack_sums(sums.patch, sums.sum))[1].tolist() == [1, (1 << 42) - 1]
    else:
        with pytest.raises(InputError, match="Sums must be 0 to"):
            pack_sums(sums.patch, sums.sum)


WORDS = st.lists(st.tuples(at_ends(0, (1 << 22) - 1), at_ends(0, (1 << 42) - 1)), max_size=9)


@SETTINGS
@given(WORDS)
def test_words_of_sums_lose_nothing(pairs):
    patch, sums = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    words = pack_sums(patch, sums)
    assert words.tolist() == [sum | patch << 42 for patch, sum in pairs]
    assert [part.tolist() for part in unpack_sums(words)] == [patch.tolist(), sums.tolist()]


def test_a_patch_beyond_the_word_is_refused():
    with pytest.raises(InputError, match="Patches must be 0 to 4194303"):
        pack_sums(np.array([1 << 22]), np.array([1]))


@SETTINGS
@given(RAYS, st.integers(0, 60))
def test_sums_of_sections_add_up_to_those_of_the_frustum(rays, cut):
    patch, weight = np.array(rays, dtype=np.int64).reshape(-1, 2).T
    weight = weight % (1 << 30)
    parts = [section_sums(patch[part], weight[part]) for part in (slice(cut), slice(cut, None))]
    added = scatter_sums([pack_sums(part.patch, part.sum) for part in parts], 13)
    expected = np.zeros(13, dtype=np.int64)
    np.add.at(expected, patch[patch >= 0], weight[patch >= 0])
    assert added.tolist() == expected.tolist()


def test_sums_of_no_patch_are_refused():
    with pytest.raises(InputError, match="Patches must be below 5, not 5"):
        scatter_sums([pack_sums(np.array([5]), np.array([1]))], 5)


def test_rays_are_read_out_row_by_row():
    assert section_rays(Sector(3, 5, 2, 4), 10).tolist() == [23, 24, 33, 34]


COMMANDS = st.builds(
    lambda left, width, right, top, height, hit_format, sums, at: ResultCommand(
        hit_format=hit_format, sums=sums, hits=64 * at, sums_address=1 << 16, columns=left + width + right,
        section=Sector(left, left + width, top, top + height)),
    st.integers(0, 9), st.integers(1, 9), st.integers(0, 9), st.integers(0, 4), st.integers(1, 4),
    st.sampled_from(HitFormat), st.booleans(), st.integers(0, 3))


def results_of(command, seed):
    random, count = np.random.default_rng(seed), len(section_rays(command.section, command.columns))
    hits = hits_of([MISS if random.random() < 0.2 else random.integers(1, [1 << 24, 1 << 20, 256, 256]).tolist()
                    for _ in range(count)])
    return hits, pack_sums(random.integers(0, 1 << 20, 5), random.integers(1, 1 << 42, 5))


@SETTINGS
@given(COMMANDS, st.integers(0, 99))
def test_every_ray_of_the_section_is_written_at_its_number_and_nothing_else(command, seed):
    hits, words = results_of(command, seed)
    memory = {}
    for address, data in result_bytes(command, hits, words).items():
        for number, byte in enumerate(data, start=address):
            assert number not in memory
            memory[number] = byte
    expected, size = {}, command.hit_format.bytes
    for position, ray in enumerate(section_rays(command.section, command.columns)):
        one = FixedHits(**{name: value[position:position + 1] for name, value in vars(hits).items()})
        for number, byte in enumerate(pack_hits(one, command.hit_format).tobytes()):
            expected[command.hits + ray * size + number] = byte
    if command.sums:
        expected |= dict(enumerate(words.tobytes(), start=1 << 16))
    assert memory == expected


@SETTINGS
@given(COMMANDS, st.integers(0, 99), st.sampled_from([64, 128, 256, 512]))
def test_beats_of_every_width_have_the_same_bytes(command, seed, data_bits):
    hits, words = results_of(command, seed)
    memory = {}
    for address, (value, strobe) in result_beats(command, hits, words, data_bits=data_bits).items():
        assert address % (data_bits // 8) == 0
        assert strobe
        for byte in range(data_bits // 8):
            if strobe >> byte & 1:
                memory[address + byte] = value >> 8 * byte & 0xFF
            else:
                assert not value >> 8 * byte & 0xFF
    assert memory == {address + number: byte for address, data in result_bytes(command, hits, words).items()
                      for number, byte in enumerate(data)}
