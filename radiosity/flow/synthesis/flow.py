"""From a component to its area (Yosys) in a family of FPGAs, and its Fmax (nextpnr) on an ECP5-85."""

import importlib.metadata
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from amaranth.back import rtlil
from amaranth.hdl import Const, Value

from golden.base.errors import InputError
from radiosity.flow.output import write_text
from radiosity.flow.synthesis.carry_folding import fold
from radiosity.flow.synthesis.copied_drivers import copy_drivers
from radiosity.flow.synthesis.family import FAMILIES, UNMAPPED, Area, Family
from radiosity.flow.synthesis.global_nets import globalise
from radiosity.flow.synthesis.hard_registers import absorb
from radiosity.flow.synthesis.near_addresses import copy_addresses
from radiosity.flow.synthesis.scan_harness import ScanHarness

__all__ = ["MHZ", "OPTIONS", "Bitstream", "Clock", "bitstream", "check_options", "pins_rtlil", "place_and_route",
           "synthesise", "synthesise_between_registers", "tool_versions", "verilog_bitstream", "yosys"]

_CHIP = ("--85k", "--package", "CABGA381")
_DEVICE = *_CHIP, "--speed", "6"
_UNCONSTRAINED = "--lpf-allow-unconstrained", "--timing-allow-fail"
# In a large unit fewer paths violate their timing than with the default weight of 10.
OPTIONS = ("--placer-heap-timingweight", "30")
# More than is achievable: with a target that is met, nextpnr considers all paths equally critical.
MHZ = 105
# Settings of nextpnr's router2, for which it has no options. Its own weight of congestion grows by 2 in each iteration:
# on a full chip it exceeds all delays before the last conflicts are resolved, and the detours make new ones. Free wires
# may lie farther from a net than its own margin of 3 tiles.
_ROUTER2 = {"router2/currCongWeightMult": "0.7", "router2/bbMargin/x": "8", "router2/bbMargin/y": "8"}
# A design that fills most of a chip: where routing follows timing, or with the weights above, conflicts of its nets
# grow again. Without timing, and with small steps of the weight, `router2` resolves them all; the placement's clock
# remains.
_ROUTABILITY_DRIVEN = _ROUTER2 | {
    "timing_driven": "0", "router2/currCongWeightMult": "0.15", "router2/bbMargin/x": "12", "router2/bbMargin/y": "12"}
# Attribute of a module: the number of LUTs that `fold` has removed.
_FOLDED = "folded_luts"
_YOSYS = """
import sys
from pyosys import libyosys as ys
design = ys.Design()
for command in sys.argv[1:]:
    ys.run_pass(command, design)
"""


@dataclass(frozen=True, kw_only=True)
class Clock:
    """The achievable Fmax of a placed and routed component.

    Parameters
    ----------
    seed
        Of the placer.
    mhz
        In MHz on speed grade 6, ports between registers.
    path
        The critical path: nanoseconds of logic delay and of routing delay, the registers at its start and its end.
    mhz_grade_8
        In MHz on speed grade 8, on the same routes; None of a bitstream, which is for grade 6.
    """

    seed: int
    mhz: float
    path: str
    mhz_grade_8: float | None = None


@dataclass(frozen=True, kw_only=True)
class Bitstream:
    """The figures of a bitstream.

    Parameters
    ----------
    area, clocks
        Its area, and the clock of each seed; the bitstream is that of the fastest.
    synthesis_seconds, route_seconds
        Processor time of synthesis, and of place and route for each seed.
    """

    area: Area
    clocks: tuple[Clock, ...]
    synthesis_seconds: int
    route_seconds: tuple[int, ...]


def tool_versions(*, clock: bool = True) -> str:
    """The versions that a table of figures must name.

    Raises
    ------
    InputError
        The tools are not installed.
    """
    try:
        found = [f"{name} {importlib.metadata.version(name)}" for name in ("amaranth", "pyosys")]
        if clock:
            said = subprocess.run([_program("nextpnr-ecp5"), "--version"], capture_output=True, text=True, check=True)
            # A native nextpnr may have the version of the packaged one, but it places differently.
            kind = " (native)" if shutil.which("nextpnr-ecp5") else ""
            found.append(re.search(r"Version ([^)]*)", said.stdout + said.stderr).group(1) + kind)
    except importlib.metadata.PackageNotFoundError as error:
        raise InputError(f"report: {error.name} is not installed; `make setup` installs it, and so does "
                         "extra 'synth'") from None
    except OSError:
        raise InputError("report: nextpnr-ecp5 is not installed; `make setup` installs it, and so does "
                         "extra 'synth'") from None
    return ", ".join(found)


def check_options(options: tuple[str, ...], *, has_constraints: bool = False) -> None:
    """Start nextpnr without a netlist: synthesis, which comes first, may take hours.

    Parameters
    ----------
    options
        Of `place_and_route`, or of `bitstream` with ``has_constraints``.

    Raises
    ------
    InputError
        nextpnr refuses an option, or ends before it would place.
    """
    own = ("--timing-allow-fail",) if has_constraints else (*_UNCONSTRAINED, *_target(options))
    tried = subprocess.run([_program("nextpnr-ecp5"), *_DEVICE, *map(str, own), "--seed", "1", "--no-route", *options],
                           capture_output=True, text=True, check=False)
    lines = [line for line in (tried.stdout + tried.stderr).splitlines() if line.strip()]
    if tried.returncode or not any("finished normally" in line for line in lines):
        said = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR:")] or lines
        raise InputError(f"report: nextpnr-ecp5 refuses {' '.join(options)}: {' '.join(said[:1])}")


def synthesise(component, folder: Path, *, family: Family = FAMILIES["ecp5"]) -> Area:
    """The area of a component alone; its netlist and the tool's log stay in ``folder``.

    Raises
    ------
    InputError
        The family has no RAM for one of its memories.
    """
    return _area(_netlist_of_rtlil(pins_rtlil(component), folder, "area", family), family)


def pins_rtlil(component) -> str:
    """A component as RTLIL, the module ``top``, with all its ports as pins."""
    ports = [Value.cast(value) for _, _, value in component.signature.flatten(component)]
    return _rtlil(component, ports=[value for value in ports if not isinstance(value, Const)])


def synthesise_between_registers(component, folder: Path) -> Path:
    """The netlist of a component between the registers of a `ScanHarness`, for an ECP5."""
    return _netlist_of_rtlil(_rtlil(ScanHarness(component)), folder, "clock", FAMILIES["ecp5"])


def place_and_route(netlist: Path, *, seed: int, options: tuple[str, ...] = OPTIONS,
                    routability_driven: bool = False) -> Clock:
    """The Fmax of a netlist for an ECP5-85: placed and routed for speed grade 6, and the same routes on grade 8.

    Designs and logs of all runs of the tool stay beside it.

    Parameters
    ----------
    seed
        Of the placer.
    options
        Of nextpnr. Without ``--freq`` the target is `MHZ`.
    routability_driven
        Whether timing decides the placement only: on a nearly full chip the router finds no timing-driven route.
    """
    clock = _place_then_route(netlist, (*_UNCONSTRAINED, *_target(options)), options, seed=seed,
                              router=_ROUTABILITY_DRIVEN if routability_driven else {})
    return replace(clock, mhz_grade_8=_mhz_grade_8(netlist, seed=seed))


def bitstream(rtlil_text: str, constraints: str, folder: Path, name: str, *, seeds: tuple[int, ...],
              options: tuple[str, ...]) -> Bitstream:
    """A bitstream and its intermediate files in ``folder``: ``name`` and ``.bit``; the tools' logs stay beside it.

    Parameters
    ----------
    rtlil_text
        The design, pins and all, as the module ``top``.
    constraints
        Where its pins are, and its clocks, as LPF.
    seeds, options
        Of the placer, which places once for each; options as of `place_and_route`.

    Raises
    ------
    InputError
        It does not fit, or misses the target clock with one of the seeds.
    """
    begin = _processor_seconds()
    netlist = _netlist_of_rtlil(rtlil_text, folder, name, FAMILIES["ecp5"])
    return _pack(netlist, constraints, seeds=seeds, options=options, router={}, begin=begin)


def verilog_bitstream(sources: tuple[Path, ...], constraints: str, folder: Path, name: str, *, seeds: tuple[int, ...],
                      options: tuple[str, ...]) -> Bitstream:
    """`bitstream` of SystemVerilog: the files in ``sources`` have the module ``top`` and all that it instantiates.

    The placement is timing-driven, the route routability-driven. ``options`` must have the target clock as ``--freq``,
    which is the only one of clocks that a PLL makes when they are routed.
    """
    begin = _processor_seconds()
    read = [f'read_verilog -sv -defer "{source.resolve()}"' for source in sources]
    netlist = _netlist(read, folder, name, FAMILIES["ecp5"])
    return _pack(netlist, constraints, seeds=seeds, options=options, router=_ROUTABILITY_DRIVEN, begin=begin)


def _pack(netlist, constraints, *, seeds, options, router, begin):
    folder, name, area = netlist.parent, netlist.stem, _area(netlist, FAMILIES["ecp5"])
    write_text(folder / f"{name}.lpf", constraints)
    clocks, times = [], [begin, _processor_seconds()]
    for seed in seeds:
        files = "--lpf", f"{name}.lpf", "--textcfg", f"{name}.seed-{seed}.config"
        clocks.append(_place_then_route(netlist, files, options, seed=seed, router=router))
        times.append(_processor_seconds())
    best = max(clocks, key=lambda clock: clock.mhz)
    _run([_program("ecppack"), "--compress", f"{name}.seed-{best.seed}.config", f"{name}.bit"],
         folder / f"{name}.ecppack.log")
    synthesis, *routes = (round(end - start) for start, end in pairwise(times))
    return Bitstream(area=area, clocks=tuple(clocks), synthesis_seconds=synthesis, route_seconds=tuple(routes))


def _processor_seconds():
    """Of this process and of the tools that have ended."""
    return sum(os.times()[:4])


def yosys(log: Path, *commands: str) -> None:
    """Run commands of Yosys, in a process of its own as it keeps its state, in the folder of its log.

    Raises
    ------
    InputError
        It failed.
    """
    _run([sys.executable, "-c", _YOSYS, *commands], log)


def _program(name):
    """The program of the machine if it has one, which is several times faster than the packaged one."""
    return shutil.which(name) or str(Path(sys.executable).with_name(f"yowasp-{name}"))


def _rtlil(component, **options):
    return rtlil.convert(component, name="top", emit_src=False, **options)


def _target(options):
    return () if any(option.split("=")[0] == "--freq" for option in options) else ("--freq", MHZ)


def _place_then_route(netlist, files, options, *, seed, router):
    """Two runs, with the placement in a file between them: it can be analysed, and routed again with other settings."""
    folder, name = netlist.parent, f"{netlist.stem}.seed-{seed}"
    placed = folder / f"{name}.placed.json"
    may_miss = () if "--timing-allow-fail" in files else ("--timing-allow-fail",)
    placed.unlink(missing_ok=True)
    # The tool sees the folder that it is started in and nothing else.
    _run([_program("nextpnr-ecp5"), "--json", netlist.name, *_DEVICE, *files, *options, "--seed", seed,
          *may_miss, "--no-route", "--write", placed.name], folder / f"{name}.placed.log")
    if not placed.exists():
        raise InputError(f"report: nextpnr-ecp5 placed nothing with {' '.join(map(str, options))}, "
                         f"see {name}.placed.log")
    design = json.loads(placed.read_text())
    # The design keeps the options of its placement. An estimate may miss the clock; a route only with the option.
    settings = design["modules"]["top"]["settings"]
    del settings["timing/allowFail"]
    settings.update(router)
    placed.write_text(json.dumps(design))
    report = folder / f"{name}.report.json"
    _run([_program("nextpnr-ecp5"), "--json", placed.name, *_DEVICE, *files, "--no-pack", "--no-place",
          "--report", report.name, "--write", f"{name}.routed.json"], folder / f"{name}.nextpnr.log")
    found = json.loads(report.read_text())
    return Clock(seed=seed, mhz=_least_mhz(found), path=_critical_path(found["critical_paths"]))


def _mhz_grade_8(netlist, *, seed):
    """The clock of the routes that `_place_then_route` found, with the delays of speed grade 8."""
    folder, name = netlist.parent, f"{netlist.stem}.seed-{seed}"
    routed, report = folder / f"{name}.grade-8.json", folder / f"{name}.grade-8.report.json"
    design = json.loads((folder / f"{name}.routed.json").read_text())
    # The speed grade and the router in a design override the command's options. ``router1`` keeps existing routes.
    design["modules"]["top"]["settings"] |= {"arch.speed": "8", "router": "router1"}
    routed.write_text(json.dumps(design))
    _run([_program("nextpnr-ecp5"), "--json", routed.name, *_CHIP, "--speed", "8", *_UNCONSTRAINED, "--no-pack",
          "--no-place", "--report", report.name], folder / f"{name}.grade-8.log")
    return _least_mhz(json.loads(report.read_text()))


def _least_mhz(report):
    return min(clock["achieved"] for clock in report["fmax"].values())


def _netlist_of_rtlil(text, folder, name, family):
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / f"{name}.il"
    source.write_text(_marked(text))
    return _netlist([f"read_rtlil {source.name}"], folder, name, family)


def _netlist(read, folder, name, family):
    """The netlist of the module ``top`` after the commands ``read`` of Yosys."""
    folder.mkdir(parents=True, exist_ok=True)
    netlist, unmapped = folder / f"{name}.json", folder / UNMAPPED
    unmapped.unlink(missing_ok=True)
    try:
        # Names like x[0] of parts of wires are purged: the mapper mistakes them for bits and fails.
        yosys(folder / f"{name}.yosys.log", *read, "hierarchy -top top", "proc",
              "opt_clean -purge", *family.commands, f"write_json {netlist.name}")
    except InputError:
        if unmapped.exists() and unmapped.read_text():
            names = ", ".join(unmapped.read_text().replace("top/", "").split())
            raise InputError(f"report: {family.title} has no RAM with the ports of {names}") from None
        raise
    if family is FAMILIES["ecp5"]:
        modules = json.loads(netlist.read_text())
        top = modules["modules"]["top"]
        top["attributes"][_FOLDED] = f"{fold(top):032b}"
        for change in absorb, copy_addresses, globalise, copy_drivers:
            change(top)
        top["settings"] = _ROUTER2
        netlist.write_text(json.dumps(modules))
    return netlist


def _marked(text):
    """Text in which the read ports of memories with ``no_rw_check`` have it too.

    What is read of a word in the cycle in which it is written is not used, so that case needs no logic. Yosys looks at
    the memory's attribute only when it makes the read ports itself, as from Verilog.
    """
    def marked(port):
        name = re.search(r'MEMID "\\(.+)"', port[0])[1]
        memory = rf"attribute \\no_rw_check 1\n(?:  attribute .*\n)*  memory .* {re.escape(name)}\n"
        if "CLK_ENABLE 1" not in port[0] or not re.search(memory, module):
            return port[0]
        # A bit for each write port; one of a port that the read port looks through has another meaning.
        return re.sub(r"(TRANSPARENCY_MASK (\d+)'0+\n.*COLLISION_X_MASK \d+')0+",
                      lambda masks: masks[1] + "1" * int(masks[2]), port[0])

    modules = re.split(r"(?m)^(?=module )", text)
    for number, module in enumerate(modules):
        if "no_rw_check" in module:
            modules[number] = re.sub(r"(?s)  cell \$memrd_v2 .*?\n  end\n", marked, module)
    return "".join(modules)


def _area(netlist, family):
    cells, folded = {}, 0
    for module in json.loads(netlist.read_text())["modules"].values():
        if "blackbox" not in module["attributes"]:
            folded += int(module["attributes"].get(_FOLDED, "0"), 2)
            for cell in module["cells"].values():
                cells[cell["type"]] = cells.get(cell["type"], 0) + 1
    return replace(family.area(cells), folded=folded)


def _critical_path(paths):
    """The critical path between registers, in words."""
    clocked = [path for path in paths if path["from"].startswith("posedge") and path["to"].startswith("posedge")]
    path = max(clocked, key=lambda path: sum(part["delay"] for part in path["path"]))["path"]
    logic = sum(part["delay"] for part in path if part["type"] != "routing")
    routing = sum(part["delay"] for part in path if part["type"] == "routing")
    first, last = (re.sub(r"(_TRELLIS_FF_\w+|_LUT4_\w+|_CCU2C_\w+|\$\S*|_DPR\w*)", "", cell)
                   for cell in (path[0]["from"]["cell"], path[-1]["to"]["cell"]))
    return f"{logic:.1f} + {routing:.1f} ns, {first} to {last}"


def _run(command, log):
    with log.open("w") as file:
        done = subprocess.run([str(part) for part in command], cwd=log.parent, stdout=file, stderr=subprocess.STDOUT,
                              check=False)
    if done.returncode:
        lines = [line for line in log.read_text(errors="replace").splitlines() if line.strip()]
        # A clock that is missed is an error of nextpnr, with others' words behind it.
        last = ([line for line in lines if line.startswith("ERROR:")] or lines)[-1:]
        raise InputError(f"report: {Path(str(command[0])).name} failed, see {log}: {' '.join(last)}")
