"""Area: what a component takes, block RAMs above all. Clock: what is placed, and the options of the tools."""

import json

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.shared_port import share_port
from hw.lib.skid_buffer import SkidBuffer
from radiosity.flow.synthesis import flow
from radiosity.flow.synthesis.flow import synthesise, synthesise_between_registers

DEPTH, WIDTH = 1024, 18


class TwoReaders(wiring.Component):
    """One block RAM's worth of words with two readers; its writer shares the port of one of them."""

    def __init__(self):
        super().__init__({"enable": In(1), "address": In(range(DEPTH)), "data": In(WIDTH),
                          "addresses": In(range(DEPTH)).array(2), "found": Out(WIDTH).array(2)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=WIDTH, depth=DEPTH, init=[], attrs={"no_rw_check": 1})
        reads = [memory.read_port() for _ in range(2)]
        for read_address, found, read in zip(self.addresses, self.found, reads, strict=True):
            m.d.comb += [read.addr.eq(read_address), found.eq(read.data)]
        share_port(reads[1], m, memory.write_port(), enable=self.enable, address=self.address, data=self.data)
        return m


def test_a_block_ram_serves_two_readers_and_who_fills_it(tmp_path):
    area = synthesise(TwoReaders(), tmp_path)
    # The choice of the address is all there is beside it.
    assert (area.bram, area.ff, area.dsp) == (1, 0, 0)
    assert area.lut <= DEPTH.bit_length()


def test_the_reset_between_registers_is_that_of_the_chip(tmp_path):
    """It takes none of the registers' own pins, where it would count as a wire."""
    netlist = json.loads(synthesise_between_registers(SkidBuffer(WIDTH), tmp_path).read_text())
    assert netlist["modules"]["top"]["settings"] == flow._ROUTER2
    cells, ports = netlist["modules"]["top"]["cells"].values(), netlist["modules"]["top"]["ports"]
    registers = [cell["connections"] for cell in cells if cell["type"] == "TRELLIS_FF"]
    assert len(registers) > 4 * WIDTH
    assert {register["LSR"][0] for register in registers} == {"0"}
    assert {register["CLK"][0] for register in registers} == set(ports["clk"]["bits"])
    reset, = (cell["connections"] for cell in cells if cell["type"] == "SGSR")
    assert reset["CLK"] == ports["clk"]["bits"]
    inverted, = (cell["connections"] for cell in cells if cell["connections"].get("Z") == reset["GSR"])
    assert ports["rst"]["bits"][0] in [inverted[pin][0] for pin in "ABCD"]


@pytest.mark.parametrize(("options", "expected"), [
    (("--placer", "static"), ["--freq", flow.MHZ]), (("--freq", "78"), ["--freq", "78"])])
def test_one_target_frequency_is_given(options, expected, monkeypatch, tmp_path):
    given = []
    monkeypatch.setattr(flow, "_place_then_route", lambda netlist, files, options, **_: (
        given.extend([*files, *options]) or flow.Clock(seed=1, mhz=1.0, path="")))
    monkeypatch.setattr(flow, "_mhz_grade_8", lambda netlist, *, seed: 2.0)
    flow.place_and_route(tmp_path / "clock.json", seed=1, options=options)
    at = given.index("--freq")
    assert given[at:at + 2] == expected
    assert given.count("--freq") == 1


@pytest.fixture(scope="module")
def placed(tmp_path_factory):
    """A netlist between registers, and its clock with router2."""
    netlist = synthesise_between_registers(SkidBuffer(2), tmp_path_factory.mktemp("placed"))
    return netlist, flow.place_and_route(netlist, seed=1, options=("--router", "router2"))


def used_settings(netlist):
    """Of the routed design."""
    routed = netlist.with_name(f"{netlist.stem}.seed-1.routed.json")
    return json.loads(routed.read_text())["modules"]["top"]["settings"]


@pytest.mark.nightly
def test_settings_reach_the_router(placed):
    """In the routed design are those that were used, and all that came."""
    settings = json.loads(placed[0].read_text())["modules"]["top"]["settings"]
    used = used_settings(placed[0])
    assert used["router"] == "router2"
    assert settings
    assert {name: used[name] for name in settings} == settings


@pytest.mark.nightly
def test_the_router_knows_all_settings(placed, tmp_path):
    """nextpnr ignores settings that it does not know. In its own design are those that it has by default."""
    design = json.loads(placed[0].read_text())
    settings = design["modules"]["top"].pop("settings")
    plain = tmp_path / "plain.json"
    plain.write_text(json.dumps(design))
    flow.place_and_route(plain, seed=1, options=("--router", "router2"))
    own = used_settings(plain)
    assert settings.keys() <= own.keys(), "a setting that router2 does not know"
    assert all(own[name] != value for name, value in settings.items())


def is_of_the_same_routes(netlist, clock):
    """Whether the clock of grade 8 is, and is as much faster as the grade is."""
    log = netlist.with_name(f"{netlist.stem}.seed-1.grade-8.log").read_text()
    return "Routing 0 arcs." in log and 1.15 * clock.mhz < clock.mhz_grade_8 < 1.5 * clock.mhz


@pytest.mark.nightly
def test_the_clock_of_grade_8_is_of_the_same_routes(placed):
    assert is_of_the_same_routes(*placed)


@pytest.mark.nightly
def test_so_is_that_of_the_other_router(tmp_path):
    netlist = synthesise_between_registers(SkidBuffer(2), tmp_path)
    assert is_of_the_same_routes(netlist, flow.place_and_route(netlist, seed=1, options=("--router", "router1")))
