"""The page of an exported core."""

from collections.abc import Mapping

from hw.package.tops import TOPS

__all__ = ["readme"]

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
| `{name}.vlt` | waivers for the warnings of Verilator's `-Wall`, with reasons |{files}

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
* `s_axil_*` is an AXI4-Lite subordinate of 32 bits: the registers, see `docs/registers.md`.
* `m_axi_*` is an AXI4 manager of {data} bits and {address} address bits. It reads and writes inside the windows that
  registers `read_base` to `write_limit` define, and nowhere else. The layout of memory: `docs/memory-map.md`.
* `irq` is active high until the host acknowledges it: completion records have been written, or the queue has
  halted. It is 0 unless the register `interrupt` enables it. The layout of jobs: `docs/job-format.md`.
"""
_ENGINE_FILES = """
| `{name}.rdl` | the registers in SystemRDL 2.0; PeakRDL writes pages, C headers and IP-XACT from it |"""
_STREAMS = """
Ports named `*_valid`, `*_ready` and `*_payload` are streams: a transfer occurs at an edge at which both are high; a
stream without `*_ready` is always ready. The fields of a payload are in the manifest; `docs/{page}` defines them.
"""


def readme(top: str, name: str, facts: Mapping[str, object], *, mhz: float) -> str:
    """The page as Markdown.

    Parameters
    ----------
    top, name, facts
        One of `TOPS`, the name of its module, and its manifest.
    mhz
        The clock of the constraints.
    """
    config, ports, is_engine = facts["parameters"], facts["ports"], top == "engine"
    meaning = _ENGINE.format(data=config["memory.data_bits"], address=config["memory.address_bits"]) if is_engine \
        else _STREAMS.format(page=TOPS[top].page)
    more = ", registers, error codes, counters" if is_engine else ", counters" if "counters" in facts else ""
    return _README.format(
        top=top, name=name, about=facts["about"], preset=facts["preset"], version=facts["version"], more=more,
        files=_ENGINE_FILES.format(name=name) if is_engine else "", mhz=mhz, meaning=meaning,
        connections=",\n".join(f"  .{port['name']}({port['name']})" for port in ports),
        ports="\n".join(f"| `{port['name']}` | {port['direction']} | {port['width']} |" for port in ports))
