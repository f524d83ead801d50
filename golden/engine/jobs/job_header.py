"""A C header with the addresses of a job."""

from collections.abc import Iterable

from golden.engine.jobs.core_manifest import CoreManifest
from golden.engine.jobs.job import Job

__all__ = ["job_header"]


def job_header(job: Job, core: CoreManifest, *, about: str, size: int) -> str:
    """The header: what a driver needs beside the bytes of `golden.engine.jobs.whole_job.memory_before`.

    Parameters
    ----------
    job
        A job of one phase.
    core
        The manifest of the core that it is for.
    about
        Of the job, a line.
    size
        Bytes of memory before the doorbell.
    """
    phase, = job.phases
    given, (first, *_) = phase.request, phase.request.records
    numbers = core.config.numbers
    unit = 1 / (given.geometry.coordinates.scale * numbers.direction.decode(first.z_scale))
    constants = {
        "CLUSTERS": (f"{core.config.noc.clusters}u", "clusters of the machine"),
        "BASE": (_address(job.base), "first byte of job.bin in main memory"),
        "BYTES": (f"{size}u", "of job.bin"),
        "END": (_address(job.end), "first byte behind the memory that the machine may read and write"),
        "RING": (_address(job.ring), "descriptors"),
        "COMPLETIONS": (_address(job.completions), "completion records"),
        "RING_BITS": (f"{job.ring_bits}u", "binary logarithm of the entries of both rings"),
        "DESCRIPTORS": (f"{len(job.descriptors)}u", "in the ring; the first one is a load"),
        "IMAGE": (_address(phase.address), "memory image, for a resume"),
        "COPIES": (f"{int(phase.image.has_copies)}u", "all clusters get the tables of cluster 0"),
        "POLICY": (f"{core.policy}u", "of the caches"),
        "HIT_FORMAT": (f"{int(given.hit_format)}u", "0: no hits, 1: 16 bytes a ray, 2: 8 bytes, 3: patch ids"),
        "SUMS": (f"{int(given.sums)}u", "sums are written"),
        "INVERSE_FRACTION_BITS": (f"{numbers.fraction_bits}u", "F of stored inverse distances, see formats.md"),
        "INVERSE_BIAS": (f"{numbers.inverse_bias}u", "B of stored inverse distances"),
        "UNIT": (repr(float(unit)), "units of the scene of a distance 1, of a screen of a depth 1"),
        "UV_BITS": (f"{core.config.icu.uv_bits}u", "of u and of v"),
        "WEIGHT_BITS": (f"{_weight_bits(given)}u", "the weights of a hemisphere are 2^W together; screen: 0"),
        "PATCHES": (f"{len(given.geometry)}u", "of the scene"),
        "FRUSTA": (f"{len(given.records)}u", "of the job"),
        "COLUMNS": (f"{first.columns}u", "of rays of each frustum"),
        "ROWS": (f"{first.rows}u", "of rays of each frustum")}
    frusta = [-1 if one is None else one.frustum for one in job.sections]
    lines = [f"#define RADIOSITY_JOB_{name} {value} /* {meaning} */" for name, (value, meaning) in constants.items()]
    return "\n".join([
        f"/* {about.replace('*/', '* /')} */",
        "#ifndef RADIOSITY_JOB_H", "#define RADIOSITY_JOB_H", "", "#include <stdint.h>", "",
        "/* SHA-256 of the core that it is for. */", f'#define RADIOSITY_JOB_CORE "{core.sha256}"', *lines,
        "/* Of each frustum: the address of its first hit. */",
        *_list("HITS", map(_address, phase.hits)),
        "/* Of each descriptor: its frustum, -1 of a load. */", *_list("FRUSTUM_OF", map(str, frusta)),
        "/* Of each descriptor: the address of its sums. */",
        *_list("SUMS_ADDRESS", (_address(int(one)) for one in job.descriptors["sums_address"])), "", "#endif", ""])


def _weight_bits(request):
    """Binary logarithm of the sum of all weights; without weights 0."""
    if request.weights is None:
        return 0
    return (int(request.weights.sum()) * request.records[0].columns).bit_length() - 1


def _address(value):
    return f"UINT64_C({value:#x})"


def _list(name: str, values: Iterable[str]):
    """An initialiser, a line for each eight values."""
    values = list(values)
    lines = ["    " + ", ".join(values[k:k + 8]) for k in range(0, len(values), 8)]
    return [f"#define RADIOSITY_JOB_{name} {{ \\", *(f"{line}, \\" for line in lines[:-1]), f"{lines[-1]} }}"]
