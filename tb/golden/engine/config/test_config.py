"""The configuration: widths, messages, presets, documentation."""

import re
from pathlib import Path

import pytest

from golden.base.errors import InputError
from golden.engine.config import PRESETS, Config, Ctu, Icu, Memory, Memsys, Noc, Numbers
from radiosity.tasks.config import about_parameters
from tb.lib.parameter_ranges import documented_ranges

GOLDEN = Path(__file__).parents[4] / "golden"
MESSAGES = [
    ("icu.rays=1000", "configuration: Rays (icu.rays) must be a power of two, not 1000"),
    ("icu.rays=8", "configuration: Rays (icu.rays) must be 64 to 4194304, not 8"),
    ("numbers.scene_bits=20", "configuration: Vector fraction (numbers.vector_fraction) must be at most "
                              "numbers.scene_bits (20), not 22"),
    ("icu.settle_fraction=7", "configuration: Settle fraction (icu.settle_fraction) must be 1 to 6, not 7"),
    ("memsys.cache_policy=fifo", "configuration: Cache policy (memsys.cache_policy) must be direct, lru, lfu, not "
                                 "'fifo'"),
    ("memsys.patch_lines=48", "configuration: Patch lines (memsys.patch_lines) must be a power of two, not 48"),
    ("memsys.own_cells=131072", "configuration: Own cells (memsys.own_cells) must be at most memsys.scene_cells "
                                "(65536), not 131072"),
    ("memsys.reply_ids=6", "configuration: Reply ids (memsys.reply_ids) must be a power of two, not 6"),
    *((f"memsys.store_patches={value}",
       f"configuration: Store patches (memsys.store_patches) must be 0, or {rule}, not {value}")
      for value, rule in ((1, "2 to 8192"), (16384, "2 to 8192"), (96, "a power of two"))),
    ("memory.data_bits=96", "configuration: Data bits (memory.data_bits) must be a power of two, not 96"),
    ("ctu.ray_slots=12", "configuration: Ray slots (ctu.ray_slots) must be a power of two, not 12"),
    ("noc.topology=star", "configuration: Topology (noc.topology) must be "
                          "mesh, torus, ring, illiac, hypercube, not 'star'"),
    ("noc.columns=64", "configuration: Columns times rows (noc.columns, noc.rows) must be at most 64, not 64 x 2"),
    ("noc.patch_nodes=8", "configuration: Patch nodes (noc.patch_nodes) must be 0 to 7, not 8"),
    ("icu.rays", "configuration: a parameter is given as PATH=VALUE, not 'icu.rays'"),
    ("icu.rays=many", "configuration: icu.rays must be of type int, not 'many'"),
]


# The range of the fraction depends on another parameter.
RANGES = [one for one in documented_ranges() if one[0] != "icu.settle_fraction"]


def test_most_parameters_have_a_documented_range():
    assert len(RANGES) > 0.75 * len(about_parameters(Config()))


@pytest.mark.parametrize(("path", "low", "high", "is_power"), RANGES)
def test_a_parameter_is_within_its_documented_range_and_not_beyond_its_ends(path, low, high, is_power):
    """Values within may break a rule about several parameters; of some 0 has a meaning of its own."""
    beyond = {low // 2, 2 * high} if is_power else {low - 1, high + 1}
    beyond -= {0} if re.search(r"\b0\b(: | has| is)|or 0", about_parameters(Config())[path]) else set()
    for value in {low, high} | beyond:
        try:
            Config().with_parameters([f"{path}={value}"])
            refused = ""
        except InputError as error:
            refused = str(error)
        says_range = re.search(rf"\({re.escape(path)}\) must be (0, or )?(0|{low}) to {high}, not {value}$", refused)
        assert bool(says_range) == (value in beyond), refused


def test_widths_are_those_of_the_design():
    numbers = Config().numbers
    widths = {name: getattr(numbers, name).width for name in
              ("scene", "vector", "direction", "vertex", "edge_plane", "inverse", "mantissa")}
    assert widths == {"scene": 24, "vector": 24, "direction": 18, "vertex": 18, "edge_plane": 36, "inverse": 24,
                      "mantissa": 25}
    assert str(numbers.vector) == "signed 1.22"


@pytest.mark.parametrize(("assignment", "message"), MESSAGES)
def test_what_cannot_be_is_refused_with_the_reason(assignment, message):
    with pytest.raises(InputError, match=f"^{re.escape(message)}$"):
        Config().with_parameters([assignment])


def test_a_burst_lies_within_a_page():
    for data_bits in 64, 128, 256, 512:
        most = min(256, 4096 * 8 // data_bits)
        given = {"memory.data_bits": data_bits, "memory.burst_beats": most}
        assert Config().replace(given).memory.beat_bytes * most <= 4096
        with pytest.raises(InputError, match=rf"\(memory.burst_beats\) must be 2 to {most}, not {2 * most}$"):
            Config().replace({**given, "memory.burst_beats": 2 * most})


def test_a_settle_code_has_no_more_fraction_bits_than_a_hit():
    changes = {"icu.settle_bits": 12, "icu.settle_fraction": 9, "numbers.fraction_bits": 8}
    with pytest.raises(InputError, match=r"^configuration: Settle fraction \(icu\.settle_fraction\) must be at most "
                                         r"numbers\.fraction_bits \(8\), not 9$"):
        Config().replace(changes)
    assert Config().replace({**changes, "icu.settle_fraction": 8}).icu.settle_fraction == 8


def test_an_unknown_parameter_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match=r"no parameter 'icu\.ray'; there are numbers\.scene_bits, .*icu\.rays"):
        Config().with_parameters(["icu.ray=64"])


def test_parameters_are_set_by_path_and_leave_the_rest():
    changed = PRESETS["paper"].with_parameters(["icu.rays=0x400", "numbers.fraction_bits=20"])
    different = {path for path, value in changed.parameters().items() if value != PRESETS["paper"].parameters()[path]}
    assert different == {"icu.rays", "numbers.fraction_bits"}
    assert changed.icu.rays == 1024


def test_a_ray_memory_for_a_larger_frustum_has_a_power_of_two_of_rays():
    config = PRESETS["tiny"]
    rays = config.icu.rays
    assert [config.for_rays(count).icu.rays for count in (1, rays, rays + 1, 2 * rays, 3 * rays)] == [
        rays, rays, 2 * rays, 2 * rays, 4 * rays]


def test_pipelines_follow_from_the_clusters_unless_given():
    assert [Ctu().traversal_pipelines(clusters) for clusters in (1, 2, 4, 8, 16)] == [2, 2, 2, 3, 4]
    assert Ctu(pipelines=1).traversal_pipelines(16) == 1


@pytest.mark.parametrize("patch_nodes", [1, 7])
def test_patch_nodes_and_lists_of_subshells_exclude_each_other(patch_nodes):
    """A node without a cluster has no list; a cluster alone beside such nodes is no exception."""
    given = {"noc.patch_nodes": patch_nodes}
    assert Config().replace(given).noc.clusters == 8 - patch_nodes
    with pytest.raises(InputError, match=rf"must be 0 where clusters have lists of subshells \(ctu\.subshell_bits\), "
                                         rf"not {patch_nodes}$"):
        Config().replace({**given, "ctu.subshell_bits": 6})


def test_networks_that_could_deadlock_are_refused():
    with pytest.raises(InputError, match=r"^configuration: Virtual channels \(noc\.virtual_channels\) must be a "
                                         r"multiple of 2 in a torus 4 x 4, not 1$"):
        Noc(topology="torus", columns=4, rows=4, virtual_channels=1)
    assert Noc(columns=4, rows=4, virtual_channels=1).node_bits == 4


def test_a_value_of_the_wrong_type_is_a_programming_error():
    for wrong in "64", 64.0, True, None:
        with pytest.raises(TypeError, match=re.escape(f"Rays (icu.rays) must be an int, not {wrong!r}")):
            Icu(rays=wrong)


def test_golden_reads_no_parameter_that_is_documented_as_the_hardwares():
    """But for what the host plans, schedules, cell sizes and jobs, and for models of cycles."""
    about = about_parameters(Config())
    hardware = [path for path, text in about.items() if text.endswith("Hardware only.")]
    assert len(hardware) >= 30
    source = "\n".join(path.read_text() for path in GOLDEN.rglob("*.py")
                       if path.parent.name not in ("config", "jobs", "machines", "schedule"))
    assert not [path for path in hardware if path in source and re.search(rf"\b{re.escape(path)}\b", source)]


def test_every_parameter_is_documented():
    for group in (Numbers, Icu, Ctu, Memsys, Memory, Noc):
        names = re.findall(r"^    ([a-z_, ]+)$", group.__doc__, re.MULTILINE)
        documented = {name for line in names for name in line.split(", ")}
        assert set(group.__dataclass_fields__) <= documented
