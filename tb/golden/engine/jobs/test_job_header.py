"""The C header of a job: a compiler reads the addresses of the job from it."""

import json
import subprocess

import pytest

from golden.engine.jobs.core_manifest import CoreManifest
from golden.engine.jobs.job_header import job_header
from golden.engine.jobs.whole_job import memory_before, whole_job
from tb.golden.engine.jobs.jobs import CONFIG, RAYS, SMALL, requests

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
