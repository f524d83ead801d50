"""The exported LiteX module connects each port, here to stand-ins for LiteX; `test_litex` has LiteX."""

import importlib.util
import json
import sys
from dataclasses import dataclass, replace
from unittest.mock import MagicMock

import pytest

from radiosity.flow.package.manifest import manifest
from radiosity.flow.package.software.software_files import software_files
from tb.radiosity.flow.package.exported_engine import CONFIG, NAME

STAND_INS = ("litedram.frontend.axi", "litex.gen", "litex.soc.cores.uart", "litex.soc.integration.soc",
             "litex.soc.integration.soc_core", "litex.soc.interconnect", "litex.soc.interconnect.csr_eventmanager",
             "migen")


@dataclass(frozen=True)
class Domain:
    """Clock or reset of a clock domain; a reset is high as long as it is active."""

    kind: str
    name: str
    inverse: bool = False

    def __invert__(self):
        return replace(self, inverse=not self.inverse)


@pytest.fixture
def litex(monkeypatch):
    """Stand-ins by the names of modules."""
    found = {name: MagicMock() for name in STAND_INS}
    for name, module in found.items():
        monkeypatch.setitem(sys.modules, name, module)
    found["litex.gen"].LiteXModule = type("LiteXModule", (), {"comb": MagicMock(), "specials": MagicMock()})
    found["litex.soc.integration.soc_core"].SoCMini = type("SoCMini", (), {})
    found["migen"].ClockSignal = lambda name: Domain("clock", name)
    found["migen"].ResetSignal = lambda name: Domain("reset", name)
    return found


@pytest.mark.parametrize("top", ["engine", "async_engine"])
def test_each_port_is_connected_and_resets_are_active_as_the_manifest_says(top, litex, monkeypatch, tmp_path):
    monkeypatch.setattr("radiosity.flow.package.manifest.unit_latencies", lambda *_: {})
    facts = manifest(top, NAME, config=CONFIG, preset="tiny", text="")
    (tmp_path / f"{NAME}.json").write_text(json.dumps(facts))
    path = tmp_path / "radiosity_soc.py"
    path.write_text(software_files(NAME, config=CONFIG, sha256="")["litex_soc/radiosity_soc.py"])
    spec = importlib.util.spec_from_file_location("radiosity_soc", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    engine = module.RadiosityEngine(MagicMock(), tmp_path)

    (name,), connections = litex["migen"].Instance.call_args
    assert name == NAME
    assert set(connections) == {f"{port['direction'][0]}_{port['name']}" for port in facts["ports"]}
    for sides in facts, *facts.get("buses", ()):
        assert connections[f"i_{sides['clock']['port']}"] == Domain("clock", "sys")
        assert connections[f"i_{sides['reset']['port']}"] == Domain(
            "reset", "sys", inverse=sides["reset"]["active"] == "low")
    assert connections["o_irq"] is litex["migen"].Signal.return_value
    assert connections["o_m_axi_awaddr"] is engine.memory.aw.addr.__getitem__.return_value
    assert connections["i_s_axil_wdata"] is engine.registers.w.data.__getitem__.return_value
