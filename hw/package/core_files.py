"""The files of a core: Verilog, constraints, a manifest and a page."""

import hashlib
import importlib.metadata
import json
from pathlib import Path

from amaranth.lib.data import Layout
from amaranth.lib.wiring import In

from golden.config import Config
from hw.cluster import COUNTERS
from hw.lib.black_box import flatten
from hw.lib.inspection import inspect
from hw.output import write_text
from hw.package.tops import TOPS
from hw.package.unit_latencies import unit_latencies
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS
from hw.registers.register import WORD_BYTES, addresses

__all__ = ["PERIOD_NS", "core_files", "write_core"]

# Clock period of the constraints.
PERIOD_NS = 10
# Warnings of Verilator that are accepted, with the reason.
WAIVERS = {
    "CASEINCOMPLETE": "where no case holds a default was assigned before",
    "CMPCONST": "limits that a configuration makes as large as the type",
    "DECLFILENAME": "one file has all modules",
    "PROCASSINIT": "registers begin with a value and are assigned at the clock: what FPGAs do",
    "UNSIGNED": "limits that a configuration makes 0",
    "UNUSEDSIGNAL": "parts of structures that a module does not look at",
    "WIDTHEXPAND": "operands are extended to the width of the result",
    "WIDTHTRUNC": "a vector is compared with 0",
}


def write_core(top: str, *, config: Config, preset: str, folder: Path) -> list[Path]:
    """Write `core_files` into a folder.

    Returns
    -------
    list
        The paths.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, text in core_files(top, config=config, preset=preset).items():
        paths.append(folder / name)
        write_text(paths[-1], text)
    return paths


def core_files(top: str, *, config: Config, preset: str) -> dict[str, str]:
    """The texts of a core by the names of their files; the same every time.

    Parameters
    ----------
    top
        One of `TOPS`.
    config
        The configuration.
    preset
        What it was made from, to be named.
    """
    name, about = f"radiosity_{top}", TOPS[top].about
    text = TOPS[top].verilog(config, name)
    head = f"// {about}.\n// Radiosity Engine {_version()}, preset {preset}. Parameters and ports: {name}.json\n\n"
    text = head + text
    facts = _facts(top, name, config, preset, text)
    return {
        f"{name}.v": text,
        f"{name}.json": json.dumps(facts, indent=1) + "\n",
        f"{name}.vlt": "".join(["`verilator_config\n", *(
            f"// {why[0].upper()}{why[1:]}.\nlint_off -rule {rule} -file \"*{name}.v\"\n"
            for rule, why in WAIVERS.items())]),
        f"{name}.f": f"{name}.v\n",
        f"{name}.sdc": f"create_clock -name clk -period {PERIOD_NS} [get_ports clk]\n",
        f"{name}.xdc": f"create_clock -name clk -period {PERIOD_NS} [get_ports clk]\n",
        f"{name}.lpf": f'FREQUENCY PORT "clk" {1000 / PERIOD_NS:g} MHZ;\n',
        f"{name}.core": _fusesoc(name, about),
        "README.md": _readme(top, name, facts),
    }


def _version():
    return importlib.metadata.version("radiosity-engine")


def _facts(top, name, config, preset, text):
    """The content of the manifest."""
    ports = [{"name": "clk", "direction": "input", "width": 1}, {"name": "rst", "direction": "input", "width": 1}]
    ports += inspect(lambda: TOPS[top].make(config), _ports)
    facts = {
        "name": name, "about": TOPS[top].about, "version": _version(), "preset": preset,
        "parameters": config.parameters(), "clock": {"port": "clk", "edge": "rising"},
        "reset": {"port": "rst", "active": "high", "synchronous": True}, "ports": ports,
        "latencies": unit_latencies(*(make(config) for make in (TOPS[top].make, *TOPS[top].parts))),
        "sha256": hashlib.sha256(text.encode()).hexdigest()}
    if top == "engine":
        offsets = addresses(ENGINE_REGISTERS)
        facts["registers"] = [
            {"name": one.name, "address": offsets[one.name], "bits": one.width, "access": one.access.value,
             "about": one.about} for one in ENGINE_REGISTERS]
    if top in ("engine", "cluster"):
        facts["counters"] = {"names": list(COUNTERS), "base": COUNTERS_BASE, "stride": WORD_BYTES << COUNTER_BITS}
    return facts


def _ports(component):
    """Names, directions, widths and fields."""
    ports = []
    for path, member, value in flatten(component):
        ports.append({"name": path, "direction": "input" if member.flow is In else "output", "width": len(value)})
        if isinstance(member.shape, Layout):
            ports[-1]["fields"] = list(_fields(member.shape))
    return ports


def _fields(layout, path="", low=0):
    """Names, lowest bits and widths of what has no parts."""
    for key, field in layout:
        name = f"{path}.{key}" if path else str(key)
        if isinstance(field.shape, Layout):
            yield from _fields(field.shape, name, low + field.offset)
        elif field.width:
            yield {"name": name, "low": low + field.offset, "width": field.width}


def _fusesoc(name, about):
    return f"""\
CAPI=2:
name: radiosity::{name}:{_version()}
description: {json.dumps(about)}
filesets:
  rtl:
    files:
      - {name}.v: {{file_type: verilogSource-2005}}
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
targets:
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
"""


_README = """\
# {name}

{about}.

Written by `radiosity verilog --top {top} --preset {preset}` of Radiosity Engine {version}; all parameters are in
`{name}.json`.

| file | is |
|---|---|
| `{name}.v` | all modules, Verilog 2005, nothing else is needed; `{name}.f` lists it |
| `{name}.json` | ports, parameters, latencies{more}, digest of the Verilog |
| `{name}.sdc`, `.xdc`, `.lpf` | the clock, {mhz:g} MHz, for Quartus and others, Vivado, and nextpnr |
| `{name}.core` | for FuseSoC; its target `lint` runs Verilator |
| `{name}.vlt` | waivers for the warnings of Verilator's `-Wall`, with reasons |

Everything happens at the rising edge of `clk`. `rst` is synchronous and active high, one cycle of it is enough.
{meaning}
```verilog
{name} instance_name (
{connections}
);
```

| port | direction | bits |
|---|---|---|
{ports}
"""
_ENGINE = """
* `host__*` is an AXI4-Lite subordinate of 32 bits: the registers, see `docs/registers.md`.
* `axi__*` is an AXI4 manager of {data} bits and {address} address bits. It reads and writes inside the windows that
  registers `read_base` to `write_limit` define, and nowhere else. The layout of memory: `docs/memory-map.md`.
* `irq` is active high until the host acknowledges it: completion records have been written, or the queue has
  halted. It is 0 unless the register `interrupt` enables it. The layout of jobs: `docs/job-format.md`.
"""
_STREAMS = """
Ports named `*__valid`, `*__ready` and `*__payload` are streams: a transfer occurs at an edge at which both are high; a
stream without `*__ready` is always ready. The fields of a payload are in the manifest; `docs/{page}` defines them.
"""


def _readme(top, name, facts):
    config = facts["parameters"]
    ports = facts["ports"]
    meaning = _STREAMS.format(page=TOPS[top].page)
    if top == "engine":
        meaning = _ENGINE.format(data=config["memory.data_bits"], address=config["memory.address_bits"])
    more = ", registers and counters" if top == "engine" else ", counters" if "counters" in facts else ""
    return _README.format(
        top=top, name=name, about=facts["about"], preset=facts["preset"], version=facts["version"], more=more,
        mhz=1000 / PERIOD_NS, meaning=meaning, connections=",\n".join(f"  .{port['name']}({port['name']})"
                                                                      for port in ports),
        ports="\n".join(f"| `{port['name']}` | {port['direction']} | {port['width']} |" for port in ports))
