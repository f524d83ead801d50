"""The files of a core: Verilog, constraints, a manifest and a page."""

import json
from importlib.metadata import version
from pathlib import Path

from golden.base.output import whole_file
from golden.base.package_version import DISTRIBUTION, package_version
from golden.engine.config import Config
from radiosity.flow.output import write_text
from radiosity.flow.package.constraints import lpf, sdc, xdc
from radiosity.flow.package.crossings import crossings, with_synchronisers
from radiosity.flow.package.example.link_example import link_example
from radiosity.flow.package.example.stream_example import SCRIPTS, stream_example
from radiosity.flow.package.flit_format import flit_format, flit_text
from radiosity.flow.package.manifest import manifest
from radiosity.flow.package.notice import LICENSE, with_notice
from radiosity.flow.package.pages import core_pages
from radiosity.flow.package.readme import readme
from radiosity.flow.package.software.software_files import software_files
from radiosity.flow.package.system_rdl import system_rdl
from radiosity.flow.package.tops import TOPS
from radiosity.flow.package.vhdl_component import vhdl_component
from radiosity.flow.verilog.plain_verilog import plain_verilog
from radiosity.flow.verilog.verilog_text import without_ram_styles

__all__ = ["core_files", "write_core"]

# Warnings of Verilator that are accepted, with the reason.
WAIVERS = {
    "CASEINCOMPLETE": "where no case holds a default was assigned before",
    "CMPCONST": "limits that a configuration makes as large as the type",
    "DECLFILENAME": "one file has all modules",
    "PROCASSINIT": "registers have an initial value and are assigned at the clock edge, as in FPGAs",
    "UNSIGNED": "limits that a configuration makes 0",
    "UNUSEDSIGNAL": "parts of structures that a module does not read",
    "WIDTHEXPAND": "operands are extended to the width of the result",
    "WIDTHTRUNC": "a vector is compared with 0",
}
# Further ones where clocks are crossed.
CROSSING_WAIVERS = {
    "SYNCASYNCNET": "a reset is synchronous in its own domain, and begins at once in the queues to another",
}


def write_core(top: str, *, config: Config, preset: str, folder: Path, **options) -> list[Path]:
    """Write `core_files` into a folder.

    Returns
    -------
    list
        The paths.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, content in core_files(top, config=config, preset=preset, **options).items():
        paths.append(folder / name)
        paths[-1].parent.mkdir(exist_ok=True)
        if isinstance(content, str):
            write_text(paths[-1], content)
        else:
            with whole_file(paths[-1]) as part:
                part.write_bytes(content)
    return paths


def core_files(top: str, *, config: Config, preset: str, period: float | None = None,
               ram_styles: bool = False) -> dict[str, str | bytes]:
    """The contents of a core's files by their paths in its folder; the same every time.

    Parameters
    ----------
    top
        One of `TOPS`.
    config
        The configuration.
    preset
        What it was made from, to be named.
    period
        Of each clock in the constraints, in nanoseconds. Default: one that has been reached, see `Top`.
    ram_styles
        Memories have the attribute ``ram_style``, which not all tools accept.
    """
    name, about, clocks = f"radiosity_{top}", TOPS[top].about, TOPS[top].clocks
    period = TOPS[top].period if period is None else period
    text = TOPS[top].verilog(config, name)
    if not ram_styles:
        text = without_ram_styles(text)
    if TOPS[top].buses:
        text = with_synchronisers(text)
    crossed = crossings(text, name) if TOPS[top].buses else []
    flits = [f"// {line}\n" for line in flit_text(flit_format(config))] if TOPS[top].is_network else []
    head = "".join([
        f"// {about}.\n// Radiosity Engine {package_version()}, preset {preset}. Parameters and ports: {name}.json\n",
        *flits, "\n"])
    text, plain = with_notice(f"{name}.sv", head + text), head + plain_verilog(text)
    facts = manifest(top, name, config=config, preset=preset, text=text)
    files = {
        f"{name}.sv": text,
        f"{name}.v": plain,
        f"{name}.json": json.dumps(facts, indent=1) + "\n",
        f"{name}.vlt": "".join(["`verilator_config\n", *(
            f"// {why[0].upper()}{why[1:]}.\nlint_off -rule {rule} -file \"*{name}.*v\"\n"
            for rule, why in (WAIVERS | (CROSSING_WAIVERS if TOPS[top].buses else {})).items())]),
        f"{name}.f": f"{name}.sv\n",
        f"{name}.sdc": sdc(clocks, period=period, crossings=crossed),
        f"{name}.xdc": xdc(clocks, period=period, crossings=crossed),
        f"{name}.lpf": lpf(clocks, period=period),
        f"{name}.vhd": vhdl_component(name, about, facts["ports"]),
    }
    if TOPS[top].is_engine:
        files[f"{name}.rdl"] = system_rdl(name, clusters=config.noc.clusters)
        files |= core_pages()
        files |= software_files(name, config=config, sha256=facts["sha256"], buses=TOPS[top].buses)
    if TOPS[top].is_network:
        files |= link_example(name, config, is_router=top == "router")
    if top in SCRIPTS:
        files |= stream_example(top, name, config)
    has_job = "job/job.bin" in files
    files[f"{name}.core"] = _fusesoc(name, about, has_job=has_job)
    files["README.md"] = readme(top, name, facts, mhz=1000 / period, has_job=has_job,
                                has_bench="example/bench.v" in files)
    files["LICENSE"] = LICENSE
    return {path: content if isinstance(content, bytes) or content is text else with_notice(path, content)
            for path, content in files.items()}


def _fusesoc(name, about, *, has_job):
    # Of versions with a commit FuseSoC makes none.
    simulation, target = (_SIMULATION.format(name=name), _SIMULATION_TARGET.format(name=name)) if has_job else ("", "")
    return f"""\
CAPI=2:
name: radiosity::{name}:{version(DISTRIBUTION)}
description: {json.dumps(about)}
filesets:
  rtl:
    files:
      - {name}.sv: {{file_type: systemVerilogSource}}
  waivers:
    files:
      - {name}.vlt: {{file_type: vlt}}
  ecp5:
    files:
      - {name}.lpf: {{file_type: LPF}}
  vivado:
    files:
      - {name}.xdc: {{file_type: xdc}}
  quartus:
    files:
      - {name}.sdc: {{file_type: SDC}}
{simulation}targets:
  default:
    filesets:
      - rtl
      - "tool_trellis? (ecp5)"
      - "tool_vivado? (vivado)"
      - "tool_quartus? (quartus)"
    toplevel: {name}
  lint:
    filesets: [rtl, waivers]
    toplevel: {name}
    flow: lint
    flow_options:
      tool: verilator
      verilator_options: [-Wall]
{target}"""


# The example casts the sample job: what it prints are the results.
_SIMULATION = """\
  simulation:
    files:
      - driver/radiosity.h: {{file_type: cSource, is_include_file: true}}
      - driver/radiosity.c: {{file_type: cSource}}
      - job/job.h: {{file_type: cSource, is_include_file: true}}
      - example/cast_job.h: {{file_type: cSource, is_include_file: true}}
      - example/cast_job.c: {{file_type: cSource}}
      - example/main.cpp: {{file_type: cppSource}}
      - job/job.bin: {{file_type: user, copyto: job.bin}}
"""
_SIMULATION_TARGET = """\
  sim:
    filesets: [rtl, waivers, simulation]
    toplevel: {name}
    flow: sim
    flow_options:
      tool: verilator
      mode: cc
      verilator_options: [-O3]
      run_options: [job.bin]
"""
