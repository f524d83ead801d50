"""The C header of a job: a compiler reads the addresses of the job from it."""

import json
import re
import subprocess

import numpy as np
import pytest

from golden.cast.frame import frame
from golden.cast.grid import Grid
from golden.cast.rays import Rays
from golden.cast.screen import Screen
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.jobs.core_manifest import CoreManifest
from golden.engine.jobs.job import PhaseRequest
from golden.engine.jobs.job_header import job_header
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.whole_job import memory_before, whole_job
from golden.scene.camera import Camera
from golden.scene.open import open_scene
from tb.golden.engine.jobs.jobs import CONFIG, RAYS, SMALL, requests, scene

PROGRAM = """
#include <stdio.h>
#include "job.h"
static const uint64_t hits[] = RADIOSITY_JOB_HITS, sums[] = RADIOSITY_JOB_SUMS_ADDRESS;
static const int32_t frustum_of[] = RADIOSITY_JOB_FRUSTUM_OF;
#define LIST(name) printf("\\"%s\\": [", #name); \\
    for (unsigned k = 0; k < sizeof name / sizeof *name; ++k) printf("%s%lld", k ? ", " : "", (long long)name[k]); \\
    printf("], ");
int main(void) {
    printf("{\\"core\\": \\"%s\\", ", RADIOSITY_JOB_CORE);
    LIST(hits) LIST(sums) LIST(frustum_of)
"""
NAMES = ("CLUSTERS", "BASE", "BYTES", "END", "RING", "COMPLETIONS", "RING_BITS", "DESCRIPTORS", "IMAGE", "COPIES",
         "POLICY", "INVERSE_FRACTION_BITS", "INVERSE_BIAS", "UV_BITS", "HIT_FORMAT", "SUMS", "WEIGHT_BITS", "PATCHES",
         "FRUSTA", "COLUMNS", "ROWS")


@pytest.mark.parametrize("number", [0, 1])
def test_a_compiler_reads_the_job_from_it(number, tmp_path):
    request = requests()[number]
    job = whole_job([request], CONFIG, base=0x12_3456_7000)
    phase, = job.phases
    core = CoreManifest(config=CONFIG, policy=2, sha256="0123")
    size = len(memory_before(job))
    (tmp_path / "job.h").write_text(job_header(job, core, about="lobby */ 5 hemispheres", size=size))
    prints = "".join(f'    printf("\\"{name}\\": %lld, ", (long long)RADIOSITY_JOB_{name});\n' for name in NAMES)
    (tmp_path / "main.c").write_text(f'{PROGRAM}{prints}    printf("\\"end\\": 0}}\\n");\n    return 0;\n}}\n')
    subprocess.run(["gcc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-o", "main", "main.c"],
                   cwd=tmp_path, check=True)
    found = json.loads(subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout)
    assert found["core"] == "0123"
    assert tuple(found["hits"]) == phase.hits
    assert found["sums"] == job.descriptors["sums_address"].tolist()
    assert found["frustum_of"] == [-1 if one is None else one.frustum for one in job.sections]
    assert {name: found[name] for name in NAMES} == {
        "CLUSTERS": CONFIG.noc.nodes, "BASE": job.base, "BYTES": size, "END": job.end, "RING": job.ring,
        "COMPLETIONS": job.completions, "RING_BITS": job.ring_bits, "DESCRIPTORS": len(job.descriptors),
        "INVERSE_FRACTION_BITS": CONFIG.numbers.fraction_bits, "INVERSE_BIAS": CONFIG.numbers.inverse_bias,
        "UV_BITS": CONFIG.icu.uv_bits, "IMAGE": phase.address, "COPIES": int(phase.image.has_copies), "POLICY": 2,
        "HIT_FORMAT": int(request.hit_format), "SUMS": 1, "WEIGHT_BITS": (RAYS, SMALL)[number].weight_bits,
        "PATCHES": len(request.geometry),
        "FRUSTA": len(request.records), "COLUMNS": request.records[0].columns, "ROWS": request.records[0].rows}


@pytest.mark.parametrize("kind", ["hemisphere", "screen"])
def test_distances_by_its_unit_are_those_of_double_precision(kind):
    """Of a screen depths along the view; in some 1 % of the rays, at edges, another patch is met."""
    open_room, geometry = open_scene("lobby"), scene().geometry
    origin, normal = open_room.bounds.mean(axis=0), np.array([0.6, 0.0, -0.8])
    if kind == "screen":
        # Its least depth is not 1 in the numbers of the machine.
        screen = Screen(camera=Camera(eye=tuple(origin), target=tuple(origin + normal), up=(0, 0, 1), fov=12.0),
                        width=16, height=16)
        record, rays = screen_record(screen, geometry.coordinates), screen.rays()
        along = rays.direction @ normal
    else:
        record = hemisphere_record(SMALL, geometry.coordinates, origin, normal)
        rays, along = Rays(np.tile(origin, (len(SMALL), 1)), SMALL.directions @ frame(normal)), 1.0
    job = whole_job([PhaseRequest(records=[record], geometry=geometry, table=scene().shelling.table,
                                  hit_format=HitFormat.FULL)], CONFIG, base=0)
    text = job_header(job, CoreManifest(config=CONFIG, policy=0, sha256="0"), about="", size=64)
    unit, fraction, bias = (float(re.search(rf"_{name} (\S+?)u? ", text)[1])
                            for name in ("UNIT", "INVERSE_FRACTION_BITS", "INVERSE_BIAS"))
    stored = NaiveFixed(geometry, CONFIG).cast(record).inverse
    inverse = (1 + stored % 2**fraction / 2**fraction) * 2.0**(stored // 2**fraction - bias)
    near = np.abs(unit / inverse / (Grid(open_room).nearest(rays).t * along) - 1) < 1e-3
    assert near[stored > 0].mean() > 0.98
