"""Stimuli: deterministic, within their formats, outputs from the inputs alone, no block forgotten."""

from itertools import cycle
from pathlib import Path

import numpy as np
import pytest

from golden import engine
from golden.base.errors import InputError
from golden.engine.config import PRESETS
from golden.engine.stimulus import BLOCKS, block, stimulus
from golden.engine.stimulus.files import write_stimulus
from tb.golden.engine.stimulus.stored_stimulus import read_stimulus

CONFIG = PRESETS["tiny"]
# Other widths than the defaults, large and small.
OTHER = CONFIG.replace({"numbers.vertex_bits": 12, "numbers.scene_bits": 20, "numbers.vector_fraction": 18,
                        "numbers.direction_fraction": 14, "numbers.mantissa_bits": 20, "numbers.fraction_bits": 12,
                        "icu.uv_bits": 6, "icu.settle_bits": 6, "icu.settle_fraction": 3, "icu.angle_bits": 20,
                        "icu.cordic_guard": 2, "icu.cordic_stages": 12})
# What is no block: a type of result, radii that are known when the tables are made, and what the hardware lacks.
NO_BLOCKS = {"icu.window", "ctu.margins", "icu.shadow_memory"}
# Caches and stores are tried with the strings of requests that scenes make, or with drawn ones.
CACHES = {"memsys.cache", "memsys.cache_policy", "memsys.lfu_placement", "memsys.set_placement",
          "memsys.reference_strings", "memsys.patch_store"}


def modules(*packages):
    root = Path(engine.__file__).parent
    return {f"{package}.{path.stem}" for package in packages for path in (root / package).rglob("*.py")} - {
        f"{package}.__init__" for package in packages}


def test_every_block_has_a_stimulus():
    assert modules("icu", "ctu", "memsys") - NO_BLOCKS - CACHES | {"cordic"} == set(BLOCKS)


@pytest.mark.parametrize("name", BLOCKS)
def test_the_same_seed_gives_the_same_arrays_and_another_one_others(name):
    first, again, other = (stimulus(name, count=40, seed=seed, config=CONFIG) for seed in (1, 1, 2))
    assert first.header == again.header
    assert all(np.array_equal(array, again.arrays[field]) for field, array in first.arrays.items())
    assert any(not np.array_equal(array, other.arrays[field]) for field, array in first.arrays.items())


@pytest.mark.parametrize("name", BLOCKS)
def test_arrays_fit_their_formats_and_shapes_in_other_widths_too(name):
    for config, seed, count in ((CONFIG, 3, 1), (CONFIG, 4, 50), (OTHER, 3, 1), (OTHER, 5, 50)):
        inputs, outputs = block(name)[1].fields(config)
        made = stimulus(name, count=count, seed=seed, config=config)
        assert [field["name"] for field in made.header["fields"]] == [field.name for field in inputs + outputs]
        for described, field in zip(made.header["fields"], inputs + outputs, strict=True):
            array = made.arrays[field.name]
            assert list(array.shape) == described["shape"]
            assert field.constant or len(array) == count
            if field.format is not None:
                assert array.dtype == np.int64
                field.format.check(array, field.name)


@pytest.mark.parametrize(("name", "suffix"), list(zip(BLOCKS, cycle((".npz", ".jsonl")))))
def test_outputs_recomputed_from_the_stored_inputs_agree(name, suffix, tmp_path):
    made = stimulus(name, count=30, seed=6, config=CONFIG)
    write_stimulus(tmp_path / f"stored{suffix}", made)
    header, arrays = read_stimulus(tmp_path / f"stored{suffix}")
    assert header == made.header
    config = PRESETS["paper"].replace(header["parameters"])
    given = {field["name"]: arrays[field["name"]] for field in header["fields"] if field["role"] == "input"}
    expected = block(name)[1].expect(given, config)
    outputs = {field["name"] for field in header["fields"]} - set(given)
    assert outputs == set(expected)
    for field in outputs:
        np.testing.assert_array_equal(arrays[field], expected[field], err_msg=field)


@pytest.mark.parametrize("name", BLOCKS)
def test_outputs_take_many_values_and_flags_both(name):
    seen = {}
    for seed in range(4):
        made = stimulus(name, count=200 if name != "ctu.unit" else 60, seed=seed, config=CONFIG)
        for field in made.header["fields"]:
            if field["role"] == "output":
                seen.setdefault(field["name"], set()).update(np.unique(made.arrays[field["name"]]).tolist())
    for field, values in seen.items():
        assert len(values) > 1, field


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    for name in ("one.npz", "two.npz", "one.jsonl", "two.jsonl"):
        write_stimulus(tmp_path / name, stimulus("icu.sbb", count=20, seed=1, config=CONFIG))
    for suffix in ("npz", "jsonl"):
        assert (tmp_path / f"one.{suffix}").read_bytes() == (tmp_path / f"two.{suffix}").read_bytes()


def test_a_short_name_is_enough_where_only_one_block_has_it():
    assert block("reciprocal")[0] == "icu.reciprocal"
    with pytest.raises(InputError, match=r"^stimulus: Block must be one of ctu\.ray_memory, icu\.ray_memory, not"):
        block("ray_memory")


@pytest.mark.parametrize(("arguments", "message"), [
    ({"count": 0}, "Count must be 1 to 1048576, not 0"), ({"seed": -1}, r"Seed must be 0 to 2\^63 - 1, not -1")])
def test_counts_and_seeds_out_of_range_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        stimulus("cordic", **{"count": 1, "seed": 0, "config": CONFIG, **arguments})
