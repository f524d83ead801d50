"""Lists of subshells that are wrong, which a load accepts: their frusta end with an error, the next one is right."""

from dataclasses import replace

import numpy as np
import pytest

from golden.engine.jobs.job import plan_job
from golden.engine.jobs.load_regions import region_bits
from golden.engine.memory_map.image import MemoryImage
from hw.registers.error_code import ErrorCode
from tb.lib.configurations import config_of
from tb.system.job_machine import BASE, LISTS, ONE_CLUSTER, SMALL, JobMachine
from tb.system.scenes import phase

CONFIG = config_of(SMALL | LISTS | {"noc.columns": 1})


def changed(image, **fields):
    """An image with other values: by region and field."""
    regions = {name: records.copy() for name, records in image.regions.items()}
    for name, value in fields.items():
        region, field = name.split("__")
        regions[region][field] = value
    return MemoryImage(regions)


def wrong_lists(image):
    """Images, the regions of them that are loaded, or all, and what a section ends with after their load."""
    yield changed(image, subshells__shell=0), None, "LIST_SHELL"
    listed = 1 << CONFIG.ctu.subshell_bits
    long = MemoryImage(image.regions | {"subshells": np.resize(image["subshells"], listed + 1)})
    yield changed(long, clusters__subshells=listed + 1), None, "LIST_LENGTH"
    # A scene with fewer patches, but the lists of the one before.
    few = image.regions | {name: image[name][:1] for name in ("patches", "residence")}
    yield changed(MemoryImage(few), patch_lists__patch=0, residents__patch=0), region_bits("cells", "patch_lists"), (
        "LIST_PATCH")
    # The patches of subshells are in main memory alone.
    yield changed(image, residence__cluster=-1, residence__address=-1), None, "PATH_RESIDENCE"


@pytest.mark.nightly
@ONE_CLUSTER
def test_wrong_lists_end_their_frusta():
    """In one job a load of what is right, one of what is wrong, and a frustum; and again."""
    request = phase("cornell", CONFIG, cell=0.25, rays=(32, 16), points=(5,) * 4, sets="scheduled")
    job = plan_job([request], CONFIG, base=BASE)
    image = job.phases[0].image
    assert (image["subshells"]["patch"] > 0).any()
    extra, errors, order, address = {}, {}, [], job.end
    for number, (wrong, regions, name) in enumerate(wrong_lists(image)):
        data = extra[address] = wrong.to_bytes()
        order += [(0, None, None), (0, address, regions), (number + 1, None, None)]
        errors |= {3 * number + 1: ErrorCode.NONE, 3 * number + 2: ErrorCode[name]}
        address += -(-len(data) // 64) * 64
    descriptors = job.descriptors[[number for number, *_ in order]]
    descriptors["tag"] = np.arange(len(order))
    for one, (_, wrong, regions) in zip(descriptors, order, strict=True):
        one["hits"] = wrong or one["hits"]
        one["regions"] = regions or one["regions"]
    sections = tuple(job.sections[number] for number, *_ in order)
    with JobMachine(replace(job, descriptors=descriptors, sections=sections), extra=extra) as machine:
        machine.right(errors)
