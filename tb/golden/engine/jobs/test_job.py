"""Jobs: every ray of every frustum in one section, and nothing in memory at the same address."""

from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.ctu.near_cells import near_cells
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.jobs.descriptor import ANY_CLUSTER, Kind, check_descriptor, section_of
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.load_regions import LOADED_REGIONS, region_bits
from golden.engine.jobs.order import proximity_order
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.memory_map import from_bytes
from golden.engine.schedule.cycle_model import least_cycles
from golden.engine.schedule.phase import schedule
from tb.golden.engine.jobs.jobs import CONFIG, hemispheres, job, memory_with, requests, scene


def test_every_ray_of_every_frustum_is_in_one_section():
    for number, phase in enumerate(job().phases):
        for frustum, record in enumerate(phase.request.records):
            rays = np.zeros((record.rows, record.columns), dtype=int)
            for section in job().numbers(number, frustum):
                one = section_of(job().descriptors[section])
                assert one == job().sections[section].section
                rays += one.mask(record)
            assert (rays == 1).all()


def test_descriptors_are_what_the_machine_executes():
    for number, (descriptor, one) in enumerate(zip(job().descriptors, job().sections, strict=True)):
        assert check_descriptor(descriptor, CONFIG) is None
        assert descriptor["tag"] == number
        assert descriptor["kind"] == (Kind.LOAD if one is None else Kind.FRUSTUM)
        if one is not None:
            phase = job().phases[one.phase]
            record, table = phase.request.records[one.frustum], phase.request.table
            assert descriptor["cluster"] == ANY_CLUSTER
            assert descriptor["hit_format"] == phase.request.hit_format
            assert descriptor["sums"] == phase.request.sums
            assert descriptor["origin"].tolist() == record.origin.tolist()
            assert descriptor["last_shell"] == CellTraversalUnit(record, table).last_shell
            assert descriptor["last_shell"] <= phase.image.last_shell


def test_phases_are_in_their_order_and_load_what_is_new():
    loads = [number for number, one in enumerate(job().sections) if one is None]
    assert [one.phase for one in job().sections if one] == [0] * 10 + [1] * 3 + [2] * 2
    assert loads == [0, 11, 15]
    rays, grid = region_bits("columns", "rows"), region_bits("shells", "grid_rows", "grid_columns")
    # The shells themselves are those of all hemispheres; there are other rays near the grid rays.
    first, second, third = job().descriptors["regions"][loads].tolist()
    assert first == LOADED_REGIONS
    assert second & ~grid == third & ~grid == rays
    assert third == rays | grid
    assert job().descriptors["hits"][loads].tolist() == [phase.address for phase in job().phases]


def test_a_phase_of_the_same_tables_is_not_loaded_again():
    first = requests()[0]
    near = replace(first, records=first.records[:1], cycles=None)
    made = plan_job([first, near, first], CONFIG)
    assert [number for number, one in enumerate(made.sections) if one is None] == [0]
    # A frustum with more shells than before needs more grid rays.
    far = max(first.records, key=lambda record: CellTraversalUnit(record, first.table).last_shell)
    close = min(first.records, key=lambda record: CellTraversalUnit(record, first.table).last_shell)
    made = plan_job([replace(first, records=[one], cycles=None) for one in (close, far)], CONFIG)
    loads = [int(made.descriptors["regions"][number]) for number, one in enumerate(made.sections) if one is None]
    assert loads == [LOADED_REGIONS, region_bits("shells", "grid_rows", "grid_columns")]


def test_what_the_machine_holds_is_not_loaded_again():
    """Neither are its tables overwritten: it reads cells and patches of them."""
    first, wider, _ = requests()
    before = plan_job([first], CONFIG)
    held = before.held
    assert (held.begin, held.end) == (before.phases[0].address, before.phases[0].address + before.phases[0].image.size)
    again = plan_job([first], CONFIG, held=held)
    assert not [one for one in again.sections if one is None]
    assert (again.held.begin, again.held.end) == (held.begin, held.end)
    assert again.base <= held.begin < held.end <= again.end
    for made in again, plan_job([first], CONFIG, held=held, base=held.begin), plan_job([wider], CONFIG, held=held):
        extents = [(made.ring, 192 << made.ring_bits), (made.completions, 64 << made.ring_bits)]
        extents += [(address, len(data)) for address, data in made.tables().items()]
        extents += [(address, 8 * len(first.records[0])) for address in made.phases[0].hits if address]
        assert all(address + size <= held.begin or address >= held.end for address, size in extents)
        # The machine may read what it holds, wherever the rings are.
        assert made.base <= min(made.ring, held.begin) < held.end <= made.end
    # Room that suffices before it is used.
    assert plan_job([first], CONFIG, ring_bits=1, held=held).ring == 0
    # Other rays are loaded alone, and the scene stays where it is.
    rays = plan_job([wider], CONFIG, held=held)
    assert rays.descriptors["regions"][0] & region_bits("cells", "patches") == 0
    assert rays.descriptors["regions"][0] & region_bits("rows")
    assert (rays.held.begin, rays.held.end) == (held.begin, held.end)


def test_a_job_below_what_the_machine_holds_ends_with_it():
    """The machine reads its tables there."""
    first = requests()[0]
    held = plan_job([first], CONFIG, base=1 << 26).held
    made = plan_job([first], CONFIG, held=held)
    assert made.ring == 0
    assert made.base == 0
    assert made.end == held.end


@pytest.mark.parametrize(("name", "loaded"), [("rows", True), ("grid_rows", False), ("grid_columns", False)])
def test_a_longer_table_serves_for_a_shorter_one_of_grid_rays_alone(name, loaded):
    request = requests()[0]
    held = plan_job([request], CONFIG).held
    longer = np.append(held.tables[name], held.tables[name][-1:])
    made = plan_job([request], CONFIG, held=replace(held, tables={**held.tables, name: longer}))
    loads = [int(made.descriptors["regions"][number]) for number, one in enumerate(made.sections) if one is None]
    assert loads == ([region_bits(name)] if loaded else [])


def test_residents_that_are_divided_otherwise_are_loaded_again():
    """They are read with the patches, cluster by cluster."""
    request = requests()[0]
    held = plan_job([request], CONFIG).held
    clusters = held.tables["clusters"].copy()
    clusters["residents"][0] -= 1
    made = plan_job([request], CONFIG, held=replace(held, tables={**held.tables, "clusters": clusters}))
    assert made.descriptors["regions"][0] == region_bits("patches", "clusters")


def test_of_another_scene_everything_is_loaded():
    """Even if its cells are the same: those and patches are read from one image."""
    request = requests()[0]
    held = plan_job([request], CONFIG).held
    patches = held.tables["patches"].copy()
    patches["vertex"][3] ^= 1
    made = plan_job([request], CONFIG, held=replace(held, tables={**held.tables, "patches": patches}))
    assert made.descriptors["regions"][0] == LOADED_REGIONS
    assert made.held.begin == made.phases[0].address >= held.end
    assert made.held.tables["patches"].tobytes() == held.tables["patches"].tobytes()


def test_nothing_in_memory_overlaps_and_addresses_are_aligned():
    made = job()
    extents = [(made.ring, 192 << 3), (made.completions, 64 << 3)]
    extents += [(address, len(data)) for address, data in made.tables().items()]
    for one in made.phases:
        size = one.request.hit_format.bytes
        extents += [(address, size * len(record)) for address, record in zip(one.hits, one.request.records, strict=True)
                    if size]
    for descriptor, one in zip(made.descriptors, made.sections, strict=True):
        if one is not None and descriptor["sums"]:
            section = section_of(descriptor)
            extents.append((int(descriptor["sums_address"]), 8 * min(section.rays, len(scene().geometry))))
    end = made.base
    assert made.base == 1024
    for address, size in sorted(extents):
        assert address % 64 == 0
        # Nor is there more room between them than that for the alignment.
        assert 0 <= address - end < 64
        end = address + size
    assert end <= made.end
    assert made.end % 64 == 0


def test_tables_in_memory_are_images_and_cells_of_shell_1():
    memory = memory_with(job(), job().tables())
    for phase in job().phases:
        assert from_bytes(bytes(memory[phase.address:phase.address + phase.image.size])).to_bytes() \
            == phase.image.to_bytes()
    for descriptor, one in zip(job().descriptors, job().sections, strict=True):
        if one is not None:
            record = job().phases[one.phase].request.records[one.frustum]
            cells = near_cells(record, scene().shelling.table, record.slopes)
            assert np.frombuffer(memory, "<u4", int(descriptor["near_count"]), int(descriptor["near_cells"])).tolist() \
                == cells.tolist()


def test_entries_of_the_rings_come_round():
    made = job()
    assert [made.entry(number) - made.ring for number in (0, 1, 7, 8, 17)] == [0, 192, 7 * 192, 0, 192]
    assert [made.completion(number) - made.completions for number in (0, 7, 8)] == [0, 448, 0]


def test_a_group_of_clusters_shares_each_frustum():
    made = plan_job([replace(requests()[0], clusters=4)], CONFIG)
    assert all(len(made.numbers(0, frustum)) == 4 for frustum in range(5))
    assert sum(one.cycles for one in made.sections if one) == pytest.approx(14)


def test_long_and_short_sections_alternate_where_every_cluster_holds_all_patches():
    cycles = [one.cycles for one in job().sections if one and one.phase == 0]
    assert cycles[0::2] + cycles[1::2] == sorted(cycles, reverse=True)


def test_the_last_section_for_each_cluster_is_cut_in_two():
    """Unless its patches take a third of its cycles."""
    least = 3 * least_cycles(len(scene().geometry))
    request = replace(requests()[0], cycles=[9 * least, 8 * least, 2 * least, least - 1, least])
    made = plan_job([request], CONFIG.replace({"icu.rays": 1024}))
    listed = [one for one in made.sections if one]
    # The three long ones and the two short ones alternate.
    assert [one.frustum for one in listed] == [0, 4, 1, 2, 2, 3]
    assert [one.cycles for one in listed[3:]] == [least, least, least - 1]
    columns = [(one.section.first_column, one.section.end_column) for one in listed]
    assert columns == [(0, 64), (0, 64), (0, 64), (0, 32), (32, 64), (0, 64)]


def test_no_section_is_cut_on_a_single_cluster():
    least = 3 * least_cycles(len(scene().geometry))
    request = replace(requests()[0], cycles=[9 * least, 8 * least, 2 * least, least - 1, least])
    made = plan_job([request], CONFIG.replace({"noc.columns": 1, "noc.rows": 1, "icu.rays": 1024}))
    assert [one.frustum for one in made.sections if one] == [0, 4, 1, 3, 2]


def test_neighbours_follow_each_other_where_clusters_share_patches_and_the_end_falls():
    made = plan_job(requests()[:1], CONFIG.replace({"memsys.own_patches": 64}))
    sections = [one for one in made.sections if one]
    # Of 2 clusters, the last four sections.
    cycles = [one.cycles for one in sections]
    assert cycles[-4:] == sorted(cycles[-4:], reverse=True)
    origins = np.array([record.origin for record in requests()[0].records])
    assert [one.frustum for one in sections[:6:2]] == [one.frustum for one in sections[1:6:2]] \
        == proximity_order(origins)[:3].tolist()


def test_subshell_lists_pin_the_sections_of_their_schedule():
    config = CONFIG.replace({"ctu.subshell_bits": 10, "icu.rays": 1024})
    records = hemispheres(3)
    plan = schedule(records[0], scene().geometry, scene().shelling.table, config, clusters=2, ratio=4, capacity=64)
    request = replace(requests()[0], records=records, cycles=None)
    for one, given, pinned in ((config, plan, True), (CONFIG, plan.without_subshells(), False)):
        made = plan_job([replace(request, plan=given)], one)
        listed = [section for section in made.sections if section]
        assert {section.cluster for section in listed} == ({0, 1} if pinned else {ANY_CLUSTER})
        for descriptor, section in zip(made.descriptors[1:], listed, strict=True):
            assert descriptor["cluster"] == section.cluster
            if pinned:
                assert section.section == plan.partition.sections[section.cluster]


@pytest.mark.parametrize(("change", "config", "options", "message"), [
    ({"cycles": [1.0]}, {}, {}, "Predicted cycles must be one for each of 5 frusta, not 1"),
    ({"hit_format": HitFormat.COMPACT}, {"icu.uv_bits": 9}, {}, "U and v must have at most 8 bits"),
    ({}, {"ctu.near_cell_bits": 5, "ctu.shell_bits": 3}, {}, "Shells must be at most 8"),
    ({}, {}, {"ring_bits": 32}, "Ring bits must be 0 to 31, not 32"),
    ({}, {}, {"ring_bits": -1}, "Ring bits must be 0 to 31, not -1"),
    ({}, {}, {"base": -1}, "Base must be at least 0, not -1")])
def test_jobs_that_the_machine_cannot_do_are_refused(change, config, options, message):
    with pytest.raises(InputError, match=message):
        plan_job([replace(requests()[0], **change)], CONFIG.replace(config), **options)


def test_a_ring_of_no_whole_number_is_a_wrong_type():
    with pytest.raises(TypeError, match="Ring bits must be an int"):
        plan_job(requests(), CONFIG, ring_bits=2.0)
