"""The host's side: drives the machine through its registers and through main memory."""

from abc import ABC, abstractmethod
from collections.abc import Iterable

import numpy as np

from golden.config import Config
from golden.errors import InputError
from golden.memory_map import REGIONS, MemoryImage
from hw.cluster import COUNTERS
from hw.memsys.cache_policy import CachePolicy
from hw.registers.engine_registers import (
    COUNTER_BITS,
    COUNTERS_BASE,
    ENGINE_REGISTERS,
    MAGIC,
    VERSION,
    register,
)
from hw.registers.error_code import ABOUT, ErrorCode
from hw.registers.register import WORD_BYTES, addresses

__all__ = ["LIVES", "EngineError", "EngineTimeoutError", "Host", "Port", "check_image"]

_NUMBER = {region.name: k for k, region in enumerate(REGIONS)}
# What is read anew with a scene, a phase, other rays and a frustum. Of ``patches`` it is the resident set. Grid rays
# follow from the rays and the number of shells: a table for more shells begins with that for fewer. ``shells`` belongs
# to each frustum, since `hw.control.frustum_load` takes the last shell from it.
LIVES = {
    "scene": ("cell_grid", "cells", "patch_lists"),
    "phase": ("residence", "clusters", "subshells", "patches"),
    "rays": ("columns", "rows", "grid_rows", "grid_columns"),
    "frustum": ("frustum", "near_cells", "shells"),
}
GRID_RAYS = 1 << 20
# Errors of a command that has changed nothing.
_REFUSED = (ErrorCode.COMMAND, ErrorCode.NOT_LOADED)
# Cycles between two reads of the status.
POLL = 100


class EngineError(Exception):
    """The machine has reported an error.

    Members
    -------
    code, cluster, address
        The registers ``error``, ``error_cluster`` and ``error_address``.
    """

    def __init__(self, code: ErrorCode, cluster: int, address: int):
        super().__init__(f"{code.name}: {ABOUT[code.name]} (cluster {cluster}, at {address:#x})")
        self.code, self.cluster, self.address = code, cluster, address


class EngineTimeoutError(Exception):
    """The machine is busy for too long."""


class Port(ABC):
    """The connection between host and machine. Addresses are of bytes; registers have 32 bits."""

    @abstractmethod
    async def read(self, address: int) -> int:
        """A register."""

    @abstractmethod
    async def write(self, address: int, value: int) -> None:
        """Write a register."""

    @abstractmethod
    async def read_memory(self, address: int, size: int) -> bytes:
        """Bytes of main memory."""

    @abstractmethod
    async def write_memory(self, address: int, data: bytes) -> None:
        """Write bytes of main memory."""

    @abstractmethod
    async def wait(self, cycles: int) -> None:
        """Let about so many cycles pass."""


def check_image(image: MemoryImage, config: Config) -> None:
    """Refuse an image that exceeds a capacity of the machine.

    Raises
    ------
    InputError
        Names the table, how long it is, and the parameter.
    """
    icu, ctu, memsys = config.icu, config.ctu, config.memsys
    clusters, shells = image["clusters"], image["shells"]
    side = 1 << icu.tile_bits

    def across(axis):
        return -(-(clusters[f"end_{axis}"].astype(np.int64) - clusters[f"first_{axis}"]) // side)

    grid_rays = int((shells["rows"].astype(np.int64) * shells["columns"]).sum())
    for what, value, most, parameter in (
            ("columns", len(image["columns"]), 1 << icu.side_bits, "icu.side_bits"),
            ("rows", len(image["rows"]), 1 << icu.side_bits, "icu.side_bits"),
            ("patches", len(image["patches"]), 1 << icu.patch_bits, "icu.patch_bits"),
            ("tiles of a section", int((across("column") * across("row")).max()), icu.rays // side**2, "icu.rays"),
            ("cells", len(image["cells"]), memsys.scene_cells, "memsys.scene_cells"),
            ("patches of a resident set", int(clusters["residents"].max()), memsys.own_patches, "memsys.own_patches"),
            ("subshells of a cluster", int(clusters["subshells"].max()), ctu.subshells, "ctu.subshell_bits"),
            ("cells of shell 1", len(image["near_cells"]), 1 << ctu.near_cell_bits, "ctu.near_cell_bits"),
            ("shells", len(shells) + 2, 1 << ctu.shell_bits, "ctu.shell_bits"),
            ("rows of grid rays", len(image["grid_rows"]), 1 << ctu.grid_row_bits, "ctu.grid_row_bits"),
            ("columns of grid rays", len(image["grid_columns"]), 1 << ctu.grid_column_bits, "ctu.grid_column_bits"),
            ("grid rays", grid_rays, GRID_RAYS, "their numbers")):
        if value > most:
            raise InputError(f"host: {what.capitalize()} must be at most {most} ({parameter}), not {value}")
    if len(clusters) != config.noc.nodes:
        raise InputError(f"host: The image must be for {config.noc.nodes} clusters, not {len(clusters)}")
    if (clusters["processor"] != np.arange(len(clusters))).any():
        raise InputError("host: Cluster k must be processor k")


class Host:
    """A driver of one machine.

    Parameters
    ----------
    port
        The connection to it.
    config
        Its configuration.
    base
        Where images are put in main memory by default, a multiple of 64.
    """

    def __init__(self, port: Port, config: Config, *, base: int = 0):
        self._port, self._config, self._base = port, config, base
        self._addresses = addresses(ENGINE_REGISTERS)
        # Images and where they are: the one whose scene has been loaded, whose frustum has, and those of the present
        # and the earlier frustum.
        self._scene = self._loaded = self._present = self._earlier = None

    async def read(self, name: str) -> int:
        """The value of a register."""
        value = 0
        for word in range(register(name).words):
            value |= await self._port.read(self._addresses[name] + WORD_BYTES * word) << 8 * WORD_BYTES * word
        return value

    async def write(self, name: str, value: int) -> None:
        """Write a register.

        Raises
        ------
        ValueError
            The register has fewer bits than the value.
        """
        if not 0 <= value < 1 << register(name).width:
            raise ValueError(f"{name} must be from 0 to {(1 << register(name).width) - 1}, not {value!r}")
        for word in range(register(name).words):
            part = value >> 8 * WORD_BYTES * word & (1 << 8 * WORD_BYTES) - 1
            await self._port.write(self._addresses[name] + WORD_BYTES * word, part)

    async def status(self) -> dict[str, int]:
        """The fields of the register ``status``."""
        return register("status").unpack(await self.read("status"))

    async def identify(self) -> None:
        """Check that the machine is there, and has the configuration.

        Raises
        ------
        InputError
            There is none, or another one.
        """
        for name, expected in ("magic", MAGIC), ("version", VERSION), ("clusters", self._config.noc.nodes):
            found = await self.read(name)
            if found != expected:
                raise InputError(f"host: The machine's {name} must be {expected}, not {found}")

    async def load(self, image: MemoryImage, *, lives: Iterable[str] = tuple(LIVES), base: int | None = None,
                   policy: CachePolicy | None = None, check: bool = True, timeout: int = 1 << 22) -> None:
        """Put an image into main memory, and have the machine read its tables.

        Parameters
        ----------
        lives
            Which of `LIVES` are read anew.
        base
            Where the image is put. The scene stays where it was loaded from, and is read from there.
        policy
            Of the caches, with a scene. Default: that of the configuration.
        check
            Check the capacities of the machine first; otherwise the machine reports an error.

        Raises
        ------
        InputError
            See `check_image`.
        EngineError, EngineTimeoutError
            The machine did not take it.
        """
        if check:
            check_image(image, self._config)
        data, at = image.to_bytes(), self._base if base is None else base
        if at + len(data) > 1 << self._config.memory.address_bits:
            raise InputError(f"host: The image must end at {1 << self._config.memory.address_bits:#x} "
                             f"(memory.address_bits) at most, not {at + len(data):#x}")
        await self.write_image(data, base=base)
        loaded = image, at
        scene = loaded if "scene" in lives else self._scene
        used = [(first, first + len(one.to_bytes())) for one, first in (loaded, scene or loaded)]
        policy = policy or CachePolicy[self._config.memsys.cache_policy.upper()]
        regions = sum(1 << _NUMBER[name] for life in lives for name in LIVES[life])
        for name, value in (
                ("image", at), ("regions", regions), ("policy", policy.value),
                ("read_base", min(first for first, _ in used)), ("read_limit", max(end for _, end in used))):
            await self.write(name, value)
        await self.command("load")
        await self.finish("loads", timeout=timeout)
        self._loaded, self._scene = loaded, scene

    async def write_image(self, data: bytes, *, base: int | None = None) -> None:
        """Put the bytes of an image into main memory."""
        await self._port.write_memory(self._base if base is None else base, data)

    async def command(self, name: str) -> None:
        """One of the register ``command``."""
        await self.write("command", register("command").pack(**{name: 1}))

    async def start(self) -> None:
        """Begin to cast what has been loaded.

        Raises
        ------
        EngineError
            The machine refuses the command. The present and the earlier frustum stay what they were.
        """
        await self.command("cast")
        if (await self.status())["failed"] and ErrorCode(await self.read("error")) in _REFUSED:
            raise await self._error()
        self._present, self._earlier = self._loaded, self._present

    async def finish(self, what: str, *, timeout: int) -> None:
        """Wait until one of the busy bits of ``status`` is 0.

        Raises
        ------
        EngineError
            Something went wrong; the error is cleared by then.
        EngineTimeoutError
            It takes longer.
        """
        waited = 0
        while True:
            status = await self.status()
            if not status[what] and not status["stops"]:
                break
            if waited >= timeout:
                raise EngineTimeoutError(f"the machine {what} after {waited} cycles still")
            await self._port.wait(POLL)
            waited += POLL
        if status["failed"]:
            raise await self._error()

    async def _error(self) -> EngineError:
        """The machine's error, which is cleared."""
        error = EngineError(ErrorCode(await self.read("error")), await self.read("error_cluster"),
                            await self.read("error_address"))
        await self.command("clear")
        return error

    async def cast(self, *, timeout: int = 1 << 26) -> int:
        """Cast what has been loaded, and return the cycles that it took."""
        await self.start()
        await self.finish("casts", timeout=timeout)
        return await self.read("cycles")

    async def results(self, *, hits: bool = True, sums: bool = True, earlier: bool = False, total: int = 0,
                      timeout: int = 1 << 24) -> MemoryImage:
        """Have results written, and read them: the image with hits and sums.

        Parameters
        ----------
        hits, sums, earlier
            See the register ``results``.
        total
            The sum of the weights of all rays.

        Raises
        ------
        InputError
            There is no such frustum.
        EngineError, EngineTimeoutError
            The machine has not written them.
        """
        frustum = self._earlier if earlier else self._present
        if frustum is None:
            raise InputError("host: A frustum must have been cast before its results are written")
        image, base = frustum
        offsets = image.offsets
        for name, value in (("total", total), ("write_base", base + offsets["hits"]),
                            ("write_limit", base + len(image.to_bytes()))):
            await self.write(name, value)
        await self.write("results", register("results").pack(hits=int(hits), sums=int(sums), earlier=int(earlier)))
        await self.command("write")
        await self.finish("writes", timeout=timeout)
        regions = {}
        for name in ("hits", "sums"):
            before = image[name]
            data = await self._port.read_memory(base + offsets[name], before.nbytes)
            regions[name] = np.frombuffer(data, dtype=before.dtype)
        return MemoryImage({**image.regions, **regions})

    async def counters(self, names: Iterable[str] = COUNTERS) -> list[dict[str, int]]:
        """Counters of each cluster, of `hw.cluster.COUNTERS`."""
        found, indices = [], {name: index for index, name in enumerate(COUNTERS)}
        for cluster in range(self._config.noc.nodes):
            first = COUNTERS_BASE + WORD_BYTES * (cluster << COUNTER_BITS)
            found.append({name: await self._port.read(first + WORD_BYTES * indices[name]) for name in names})
        return found

    async def stop(self, *, timeout: int = 1 << 20) -> None:
        """Reset all units. All regions must be loaded again."""
        await self.command("stop")
        self._scene = self._loaded = self._present = self._earlier = None
        await self.finish("stops", timeout=timeout)
