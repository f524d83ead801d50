"""The format of flits, for those who connect other nodes to an exported network."""

from collections.abc import Mapping

from golden.engine.config import Config
from golden.engine.noc.packing import CHECK_BITS, VERTICES
from hw.noc.packet_headers import packet_headers

__all__ = ["flit_format", "flit_text"]

_CHECKED = {"none": "", "parity": ", and above it its parity with `first` and `last`",
            "crc": ", and above it the remainder by x^8 + x^2 + x + 1 of `last`, `first`, data, from the highest bit"}


def flit_format(config: Config) -> dict[str, object]:
    """The format, as JSON has it: bits of a flit's data and of its check; of packets the flits and the header."""
    bits = config.noc.flit_bits
    headers = packet_headers(config, config.noc.nodes)
    vertex = 3 * config.numbers.scene.width
    packets = {}
    for kind, layout in headers.items():
        own, vertices = -(-layout.size // bits), VERTICES if kind == "reply" else 0
        each = -(-vertex // bits)
        packets[kind] = {
            "flits": own + vertices * each, "header_flits": own, "vertices": vertices, "vertex_bits": vertex,
            "vertex_flits": each, "header": [
                {"name": name, "low": field.offset, "width": field.width} for name, field in layout if field.width]}
    return {"data_bits": bits, "check": config.noc.check, "check_bits": CHECK_BITS[config.noc.check],
            "packets": packets}


def flit_text(facts: Mapping[str, object]) -> list[str]:
    """`flit_format` in lines of words."""
    lines = [f"A flit has {facts['data_bits']} bits of data{_CHECKED[facts['check']]}; `first` and `last` are those of "
             "its packet."]
    for kind, packet in facts["packets"].items():
        header = ", ".join(f"{field['name']} {field['low'] + field['width'] - 1}:{field['low']}"
                           for field in packet["header"])
        body = (f"; then {packet['vertices']} vertices of {packet['vertex_bits']} bits, x lowest, each in "
                f"{packet['vertex_flits']}" if packet["vertices"] else "")
        lines.append(f"A {kind} has {packet['flits']}: {packet['header_flits']} of the header, {header}{body}.")
    return lines
