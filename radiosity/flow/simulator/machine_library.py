"""The engine, its main memory and a manager of its registers as a compiled library."""

import os
import shutil
import subprocess
from pathlib import Path

from golden.base.stage_progress import StageProgress
from golden.engine.config import Config
from hw.engine import CLUSTER
from radiosity.flow.simulator.build_folder import build_folder, content_key, keep_newest, locked, temporary_folder
from radiosity.flow.simulator.machine_verilog import cluster_verilog, export_beside, top_verilog
from radiosity.flow.simulator.traced_verilog import traced_verilog
from radiosity.flow.simulator.verilator import OPTIMIZATION, check_tools, verilator_package, verilator_version

__all__ = ["HARNESS", "machine_library"]

# What drives the pins of the engine: main memory and host, in C++.
HARNESS = Path(__file__).with_name("machine.cpp")
_FLAGS = ("-Wno-fatal", "-O3", "--x-assign", "fast", "--x-initial", "fast", "--noassert")
_TRACE = "--trace-vcd"
# One unit for each module: reading the headers again for each file takes longer than to compile them.
_MAKE = ("make", "-j2", "VM_PARALLEL_BUILDS=0", f"OPT_FAST={OPTIMIZATION}", f"OPT_GLOBAL={OPTIMIZATION}")
# Seconds on two idle cores, for machines of several clusters with preset paper.
_STAGES = {"export Verilog": 7.0, "run Verilator": 14.0, "compile": 18.0}
_LIBRARY, _LOG = "machine.so", "build.log"


def machine_library(config: Config, *, traced: bool = False, progress: bool = False) -> Path:
    """The library of an engine; compiled unless the same sources have been compiled before.

    Parameters
    ----------
    config
        The configuration.
    traced
        The library can write waveforms, see `radiosity.flow.simulator.traced_verilog.traced_verilog`, and is slower.
    progress
        Show the progress of a build on stderr.

    Raises
    ------
    InputError
        Verilator or the compiler is not installed.
    RuntimeError
        Verilator or the compiler fails; the message names the log.
    """
    flags = (*_FLAGS, *([_TRACE] if traced else []))
    parent = build_folder() / "machines"
    parent.mkdir(parents=True, exist_ok=True)
    with StageProgress("build the simulator", _STAGES, shown=progress, record=build_folder() / "durations.json") as bar:
        with bar.stage("export Verilog"), export_beside(config):
            cluster = cluster_verilog(config)
        top = top_verilog(config)
        if traced:
            top, cluster = traced_verilog(top), traced_verilog(cluster)
        folder = parent / content_key(top, cluster, HARNESS.read_text(), config.memory.beat_bytes, *_tools(flags))
        with locked(folder):
            if not (folder / _LIBRARY).exists():
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir()
                with temporary_folder(folder.name) as work:
                    _Build(folder, work, config, flags, bar).run(top, cluster)
                bar.keep()
                keep_newest(parent, built=folder)
            os.utime(folder)
    return folder / _LIBRARY


def _tools(flags):
    """What a build depends on beside its sources."""
    return verilator_version(), flags, _MAKE


class _Build:
    """One run of Verilator and of the compiler: intermediate files are in ``work``, library and log in ``folder``."""

    def __init__(self, folder: Path, work: Path, config: Config, flags: tuple[str, ...], progress: StageProgress):
        self._folder, self._work, self._config = folder, work, config
        self._flags, self._progress = flags, progress
        self._traced = _TRACE in flags
        check_tools()
        self._package = verilator_package()
        self._root = self._package / "share" / "verilator"

    def run(self, top: str, cluster: str) -> None:
        """From Verilog to the library."""
        (self._work / "top.v").write_text(top)
        (self._work / "cluster.v").write_text(cluster)
        # One cluster is faster as a part of the whole. Several share one compiled module.
        objects = []
        if self._config.noc.clusters > 1:
            # The model and what connects it, without Verilator's runtime, which the rest has.
            objects += [f"V{CLUSTER}/V{CLUSTER}__ALL.o", f"V{CLUSTER}/{CLUSTER}.o"]
            self._build_around_cluster(cluster, objects)
        else:
            with self._progress.stage("run Verilator"):
                self._verilate("top", "top.v", "cluster.v")
            with self._progress.stage("compile"):
                self._make("top")
        include = self._root / "include"
        self._call("g++", "-shared", "-fPIC", "-I.", f"-I{include}", f"-I{include / 'vltstd'}", "-faligned-new", "-O2",
                   f"-DBEAT_BYTES={self._config.memory.beat_bytes}", f"-DVM_TRACE={int(self._traced)}",
                   str(HARNESS.resolve()), "-o", "part.so", "libVtop.a", *objects, "libverilated.a", "-pthread")
        (self._work / "part.so").rename(self._folder / _LIBRARY)

    def _build_around_cluster(self, cluster, objects):
        """The module of the clusters as objects, compiled while Verilator runs on the rest; kept for other machines
        with the same clusters.
        """
        wrapper = f"V{CLUSTER}/{CLUSTER}.sv"
        kept = build_folder() / "clusters" / content_key(cluster, *_tools(self._flags))
        kept.parent.mkdir(parents=True, exist_ok=True)
        with locked(kept):
            compiler = None
            with self._progress.stage("run Verilator"):
                if kept.exists():
                    for name in (*objects, wrapper):
                        (self._work / name).parent.mkdir(exist_ok=True)
                        shutil.copyfile(kept / Path(name).name, self._work / name)
                    os.utime(kept)
                else:
                    self._verilate(CLUSTER, "cluster.v", "--lib-create", CLUSTER, folder=f"V{CLUSTER}")
                    compiler = self._start(*_MAKE, "-C", f"V{CLUSTER}", "-f", f"V{CLUSTER}.mk",
                                           *(Path(name).name for name in objects))
                self._verilate("top", "top.v", wrapper)
            with self._progress.stage("compile"):
                self._make("top")
                if compiler:
                    self._finish(compiler, "make")
                    part = kept.with_suffix(".part")
                    shutil.rmtree(part, ignore_errors=True)
                    part.mkdir()
                    for name in (*objects, wrapper):
                        shutil.copyfile(self._work / name, part / Path(name).name)
                    part.rename(kept)
                    keep_newest(kept.parent, built=kept)

    def _verilate(self, module, *words, folder="."):
        self._call(str(self._package / "bin" / "verilator_bin"), "--cc", *words, "--top-module", module, "--prefix",
                   f"V{module}", *self._flags, "--Mdir", folder, "-CFLAGS", "-fPIC")

    def _make(self, module):
        self._call(*_MAKE, "-f", f"V{module}.mk", f"libV{module}.a", "libverilated.a")

    def _call(self, *command: str):
        self._finish(self._start(*command), Path(command[0]).name)

    def _start(self, *command: str):
        environment = os.environ | {"VERILATOR_ROOT": str(self._root),
                                    **({"OBJCACHE": "ccache"} if shutil.which("ccache") else {})}
        with (self._folder / _LOG).open("a") as log:
            return subprocess.Popen(command, cwd=self._work, env=environment, stdout=log, stderr=log)

    def _finish(self, process, name):
        if process.wait():
            raise RuntimeError(f"{name} fails: see {self._folder / _LOG}")
