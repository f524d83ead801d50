"""The engine, its main memory and a manager of its registers as a compiled library."""

import os
import shutil
import subprocess
from pathlib import Path

from golden.config import Config
from hw.engine import CLUSTER
from hw.simulator.build_folder import build_folder, content_key, keep_newest, locked
from hw.simulator.machine_verilog import cluster_verilog, top_verilog
from hw.simulator.verilator import verilator_package

__all__ = ["HARNESS", "machine_library"]

# What drives the pins of the engine: main memory and host, in C++.
HARNESS = Path(__file__).with_name("machine.cpp")
_FLAGS = ("-Wno-fatal", "-O3", "--x-assign", "fast", "--x-initial", "fast", "--noassert", "--output-groups", "6")
_TRACE = "--trace-vcd"
# What runs once is not worth the compiler's time.
_MAKE = ("make", "-j2", "VM_PARALLEL_BUILDS=1", "OPT_FAST=-O1", "OPT_SLOW=-O0", "OPT_GLOBAL=-O1")
_LIBRARY, _LOG = "machine.so", "build.log"


def machine_library(config: Config, *, traced: bool = False) -> Path:
    """The library of an engine; compiled unless the same sources have been compiled before.

    Parameters
    ----------
    config
        The configuration.
    traced
        The library can write waveforms, and is slower.

    Raises
    ------
    InputError
        Verilator is not installed.
    RuntimeError
        Verilator or the compiler fails; the message names the log.
    """
    top, cluster = top_verilog(config), cluster_verilog(config)
    flags = (*_FLAGS, *([_TRACE] if traced else []))
    parent = build_folder() / "machines"
    folder = parent / content_key(top, cluster, HARNESS.read_text(), config.memory.beat_bytes, flags)
    library = folder / _LIBRARY
    parent.mkdir(parents=True, exist_ok=True)
    with locked(folder):
        if not library.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            _Build(folder, config, flags).run(top, cluster)
            keep_newest(parent)
        os.utime(folder)
    return library


class _Build:
    """One run of Verilator and of the compiler in a folder."""

    def __init__(self, folder: Path, config: Config, flags: tuple[str, ...]):
        self._folder, self._config, self._flags = folder, config, flags
        self._traced = _TRACE in flags
        # One cluster is faster as a part of the whole. Several share one compiled module, which has no waveforms.
        self._shared = config.noc.nodes > 1 and not self._traced
        self._package = verilator_package()
        self._root = self._package / "share" / "verilator"

    def run(self, top: str, cluster: str) -> None:
        """From Verilog to the library; nothing else stays but the log."""
        (self._folder / "top.v").write_text(top)
        (self._folder / "cluster.v").write_text(cluster)
        (self._folder / "blocks.vlt").write_text(f'`verilator_config\nhier_block -module "{CLUSTER}"\n')
        archive = f"V{CLUSTER}/lib{CLUSTER}.a"
        self._verilate()
        if self._shared:
            self._compile_cluster(cluster, archive)
        self._call(*_MAKE, "-f", "Vtop.mk", "libVtop.a", "libverilated.a")
        include = self._root / "include"
        self._call("g++", "-shared", "-fPIC", "-I.", f"-I{include}", f"-I{include / 'vltstd'}", "-faligned-new", "-O2",
                   f"-DBEAT_BYTES={self._config.memory.beat_bytes}", f"-DVM_TRACE={int(self._traced)}",
                   str(HARNESS.resolve()), "-o", "part.so", "libVtop.a", *([archive] if self._shared else []),
                   "libverilated.a", "-pthread")
        for path in list(self._folder.iterdir()):
            if path.is_dir():
                shutil.rmtree(path)
            elif path.name not in ("part.so", _LOG):
                path.unlink()
        (self._folder / "part.so").rename(self._folder / _LIBRARY)

    def _verilate(self):
        self._call(str(self._package / "bin" / "verilator_bin"), "--cc",
                   *(["--hierarchical", "blocks.vlt"] if self._shared else []), "top.v", "cluster.v", "--top-module",
                   "top", "--prefix", "Vtop", *self._flags, "--Mdir", ".", "-CFLAGS", "-fPIC")

    def _compile_cluster(self, cluster, archive):
        """The module of the clusters, from a machine that has had the same one if there is any."""
        wrapper = f"V{CLUSTER}/{CLUSTER}.sv"
        kept = build_folder() / "clusters" / content_key(cluster, self._flags)
        kept.parent.mkdir(parents=True, exist_ok=True)
        with locked(kept):
            if kept.exists():
                for name in archive, wrapper:
                    (self._folder / name).parent.mkdir(exist_ok=True)
                    shutil.copyfile(kept / Path(name).name, self._folder / name)
            self._call(*_MAKE, "-f", "Vtop_hier.mk", archive)
            if not kept.exists():
                part = kept.with_suffix(".part")
                shutil.rmtree(part, ignore_errors=True)
                part.mkdir()
                for name in archive, wrapper:
                    shutil.copyfile(self._folder / name, part / Path(name).name)
                part.rename(kept)
                keep_newest(kept.parent)

    def _call(self, *command: str):
        environment = os.environ | {"VERILATOR_ROOT": str(self._root),
                                    **({"OBJCACHE": "ccache"} if shutil.which("ccache") else {})}
        with (self._folder / _LOG).open("a") as log:
            done = subprocess.run(command, cwd=self._folder, env=environment, stdout=log, stderr=log, check=False)
        if done.returncode:
            raise RuntimeError(f"{Path(command[0]).name} fails: see {self._folder / _LOG}")
