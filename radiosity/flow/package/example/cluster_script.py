"""The example of a cluster: a hemisphere in the lobby, most of whose patches other clusters and main memory hold."""

import numpy as np

from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.config import Config
from golden.engine.ctu.near_cells import near_cells
from golden.engine.ctu.sector import Sector
from golden.engine.frustum.frustum_choice import FrustumChoice
from golden.engine.icu.patch_sums import section_sums
from golden.engine.jobs.descriptor import frustum_descriptor
from golden.engine.jobs.result_formats import HitFormat, ResultCommand, pack_sums, result_bytes
from golden.engine.schedule.job_shelling import job_shelling
from golden.scene.open import open_scene
from hw.cluster import Cluster
from hw.control.job_formats import COMPLETION_WORDS, NEAR_INDEX, elements
from hw.formats import Formats
from hw.lib.payload import pack
from hw.memsys.patches.path_formats import PathFormats, RequestKind
from hw.memsys.port.beat_writer import GROUP_BITS
from hw.registers.error_code import ErrorCode
from radiosity.flow.package.example.fitting_image import fitting_image
from radiosity.flow.package.example.icu_script import vertices
from radiosity.flow.package.example.image_words import patch_words, words
from radiosity.flow.package.example.stream_script import Script

__all__ = ["cluster_script"]

_SCENE, _FRUSTUM, _CELL = "lobby", {"patch": 4, "rays": (32, 8)}, 0.5
# Patches that a cluster holds, and how many of them another cluster requests.
_OWN, _REQUESTED = 16, 5
# Where results go.
_HITS, _SUMS = 2 << 15, 3 << 15
# Cycles from the last word of a load until it is in its table, and more.
_STORES = 64


def cluster_script(unit: Cluster, config: Config) -> Script:
    """Tables, a section, requests of another cluster; then patches as the cluster requests them, results as it writes
    them, and the end.

    Parameters
    ----------
    unit, config
        The cluster, which has the number 0, and its configuration.

    Raises
    ------
    InputError
        See `fitting_image`.
    """
    script, scene = Script(unit), open_scene(_SCENE)
    record, geometry, weights = FrustumChoice(**_FRUSTUM).record(scene, config)
    table = job_shelling(geometry, config, cell=_CELL).table
    image = fitting_image(record, geometry, table, config, weights=weights, own_patches=_OWN,
                          hit_format=HitFormat.FULL, sums=True, hits=_HITS, sums_address=_SUMS)
    for port in "number", "reset", "cycle", "counter":
        script.hold(port, 0)
    script.hold("scene", {"cells": len(table), "lists": len(image["patch_lists"]), "patches": len(geometry)})
    script.give("i_word", [{"item": item, "cluster": 0, "is_all": 0} for item in (*words(image, 0),
                                                                                  *patch_words(image, 0))])
    script.next_step(pause=_STORES)
    _serve(script, geometry, image, config)
    command = ResultCommand(hit_format=HitFormat.FULL, sums=True, hits=_HITS, sums_address=_SUMS,
                            columns=record.columns, section=Sector.whole(record))
    script.give("i_job", _section(record, table, command))
    hits = NaiveFixed(geometry, config).cast(record)
    sums = section_sums(hits.patch, weights[np.arange(len(record)) // record.columns])
    _require_writes(script, result_bytes(command, hits, pack_sums(sums.patch, sums.sum)), config)
    # The counter of cycles stands still; other counters depend on cycles.
    ends = [0] * COMPLETION_WORDS
    compared = dict.fromkeys(range(COMPLETION_WORDS), 0)
    for field, value in {"error": ErrorCode.NONE.value, "address": 0, "sums": len(sums.patch), "begin": 0,
                         "end": 0}.items():
        for word, bits in elements(field, record="completion"):
            ends[word] |= value << bits.start
            compared[word] |= (1 << bits.stop) - (1 << bits.start)
    script.require("o_end", ends, compared=list(compared.values()))
    script.ends_with("fault", {})
    return script


def _serve(script, geometry, image, config):
    """Patches for another cluster, of others, and of main memory."""
    mine, home, path = image.residents(0), image["residence"]["cluster"], PathFormats(config)
    served = mine[:_REQUESTED]
    script.give("i_remote", [{"node": 1, "patch": int(patch)} for patch in served])
    script.require("o_remote", [{"node": 1, "vertex": vertex} for vertex in vertices(geometry, served)])
    others = {patch: vertices(geometry, np.array([patch])) for patch in range(len(geometry)) if patch not in mine}
    script.answer("o_request", "i_reply", {
        pack(path.remote_request, {"node": int(home[patch]), "patch": patch}): beats
        for patch, beats in others.items() if home[patch] > 0})
    replies = {}
    for patch, beats in others.items():
        data = [pack(path.patch_head, {"patch": patch, "surface": beats[0]["surface"]}), *(
            pack(Formats(config).scene_vector, beat["vertex"]) for beat in beats)]
        replies[pack(path.request, {"kind": RequestKind.PATCH.value, "key": patch})] = [
            {"cluster": 0, "kind": RequestKind.PATCH.value, "last": number == len(data) - 1, "data": one}
            for number, one in enumerate(data)]
    script.answer("o_bus", "i_bus", replies)


def _section(record, table, command):
    """The words of a section's descriptor and of its near cells."""
    descriptor = frustum_descriptor(record, table, hit_format=command.hit_format, sums=command.sums, cluster=0,
                                    hits=command.hits, sums_address=command.sums_address)
    near = near_cells(record, table, record.slopes).astype("<u4")
    sent = [*enumerate(np.frombuffer(descriptor.tobytes(), "<u8").tolist()),
            *((NEAR_INDEX, word) for word in np.frombuffer(np.pad(near, (0, len(near) % 2)).tobytes(), "<u8").tolist())]
    return [{"cluster": 0, "index": index, "data": data, "last": place == len(sent) - 1, "void": 0}
            for place, (index, data) in enumerate(sent)]


def _require_writes(script, extents, config):
    """Bytes by address as requests with their beats, each answered before the next one."""
    beat, most = config.memory.beat_bytes, 1 << min(GROUP_BITS, config.memory.length_bits)
    merged = {}
    for address, data in sorted(extents.items()):
        first = next((begin for begin, before in merged.items() if begin + len(before) == address), address)
        merged[first] = merged.get(first, b"") + data
    for address, data in merged.items():
        for begin in range(0, len(data), beat * most):
            part = data[begin:begin + beat * most]
            beats = [part[k:k + beat] for k in range(0, len(part), beat)]
            script.require("o_write", [{"address": address + begin, "length": len(beats) - 1, "tag": 0}])
            script.require("o_write_data", [
                {"data": int.from_bytes(one, "little"), "strobe": (1 << len(one)) - 1} for one in beats])
            script.next_step()
            script.give("i_written", [{"tag": 0, "error": 0}])
