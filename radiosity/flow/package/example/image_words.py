"""The words of an image that a cluster is given."""

from collections.abc import Iterator

import numpy as np

from golden.engine.memory_map import REGIONS, MemoryImage
from hw.memsys.load.image_layout import PATCH_WORDS, RegionNumber

__all__ = ["patch_words", "words"]


def words(image: MemoryImage, cluster: int) -> Iterator[dict]:
    """What the preload DMA gives for a cluster, region by region: values of `MemoryFormats.table_word`."""
    for number, region in enumerate(REGIONS):
        array = image[region.name]
        if region.name == "clusters":
            array = array[cluster:cluster + 1]
        elif region.name == "subshells":
            listed = image.subshells(cluster)
            array = np.zeros(len(listed), dtype=array.dtype)
            array["patch"], array["shell"] = listed.T
        if region.name in ("patches", "residents") or not len(array):
            continue
        data = np.frombuffer(array.tobytes(), dtype="<u4" if region.dtype.itemsize == 4 else "<u8")
        for record, row in enumerate(data.reshape(len(array), -1)):
            for word, value in enumerate(row):
                yield {"region": RegionNumber(number).value, "record": record, "word": word, "data": int(value)}


def patch_words(image: MemoryImage, cluster: int) -> Iterator[dict]:
    """The patches of a cluster's resident set, as of `words`, by their local addresses."""
    for address, patch in enumerate(image.residents(cluster)):
        for word, value in enumerate(np.frombuffer(image["patches"][patch].tobytes(), dtype="<u8")[:PATCH_WORDS]):
            yield {"region": RegionNumber.PATCHES.value, "record": address, "word": word, "data": int(value)}
