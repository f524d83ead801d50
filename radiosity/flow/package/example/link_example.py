"""The example of a router or network: a whole network, each flit in the cycle in which the golden model has it."""

import numpy as np

from golden.engine.config import Config
from golden.engine.noc.link_words import LinkWords, link_words
from golden.engine.noc.network import Network, Packets
from golden.engine.noc.packing import VERTICES, reply_flits, request_flits
from golden.engine.noc.topology import LOCAL, Topology
from hw.noc.network_parameters import network_parameters
from radiosity.flow.package.example.templates import example_files

__all__ = ["FLITS", "link_example"]

# Flits that the network carries at least, and those of a node in a cycle.
FLITS, _LOAD = 10_000, 0.8
# Most cycles, and entries of the patterns in which sources and sinks stall, with the share of those in which they do.
_CYCLES, _PATTERN, _STALLS = 1_000_000, 503, 0.15


def link_example(name: str, config: Config, *, is_router: bool) -> dict[str, str]:
    """The contents of the files by their paths in the folder of the core; none if there is one node.

    Parameters
    ----------
    name
        Of the module: a network, or a router whose node is an input.
    config
        The configuration.
    is_router
        The network is made of routers.
    """
    topology = config.noc.network()
    if topology.nodes == 1:
        return {}
    given, required, flits = _words(config)
    module = f"{name}_network" if is_router else name
    sources = [f"../{name}.v", *(["network.v"] if is_router else []), "words.v"]
    width = given.link_bits * given.links
    files = example_files("link", {
        "NAME": name, "WIDTH": str(width), "LINKS": str(given.links), "LINK": str(given.link_bits),
        "CYCLES": str(given.cycles), "FLITS": str(flits), "MAKE_SOURCES": " ".join(sources),
        "SOURCES": ", ".join(f'"{source}"' for source in sources)})
    files |= {f"example/{file}.hex": "".join(f"{word:0{-(-width // 4)}x}\n" for word in side.words)
              for file, side in (("given", given), ("required", required))}
    files["example/words.v"] = _words_module(module, "" if is_router else " .flits(), .stalls(),", given)
    if is_router:
        files["example/network.v"] = _network_module(module, name, topology, given)
    return files


def _words(config):
    """Requests and replies from node to node, all of which arrive, and how many flits they have."""
    parameters, generator = network_parameters(config), np.random.default_rng(1)
    routing, messages, nodes = parameters["routing"], parameters["messages"], config.noc.nodes
    lengths = [len(_packet(config, kind, 0, 0, generator)) for kind in range(2)]
    count = -(-2 * FLITS // sum(lengths)) + nodes
    kinds = np.arange(count) % 2
    length = np.array(lengths)[kinds]
    ends = generator.integers(0, nodes, (2, count))
    cycles = int(length.sum() / _LOAD / nodes)
    packets = Packets(source=ends[0], destination=ends[1], length=length,
                      made=np.sort(generator.integers(0, cycles, count)), message=kinds * (messages - 1))
    stalls = generator.random((2, _PATTERN, nodes)) < _STALLS
    arrivals = Network(routing, buffer_flits=parameters["depth"], messages=messages,
                       arbitration=config.noc.arbitration, router_cycles=parameters["router_cycles"]).run(
        packets, cycles=_CYCLES, source_stalls=stalls[0], sink_stalls=stalls[1])
    data = [word for kind, source, destination in zip(kinds, *ends, strict=True)
            for word in _packet(config, kind, int(source), int(destination), generator)]
    given, required = link_words(packets, arrivals, data, nodes=nodes, bits=parameters["bits"],
                                 channels=messages * routing.virtual_channels)
    return given, required, len(data)


def _packet(config, kind, source, destination, generator):
    """The data of the flits of a request (0) or a reply (1) for a patch."""
    of = {"source": source, "destination": destination,
          "patch": int(generator.integers(0, 1 << config.icu.patch_bits))}
    if kind == 0:
        flits = request_flits(config, **of)
    else:
        vertices = generator.integers(0, 1 << config.numbers.scene.width, (VERTICES, 3)).tolist()
        flits = reply_flits(config, **of, surface=int(generator.integers(0, 1 << 31)), vertices=vertices)
    return [data for data, _, _ in flits]


def _words_module(module, counters, words: LinkWords):
    """The network with all links of a side as one word; nothing reads its counters."""
    width, link, payload = words.link_bits * words.links, words.link_bits, words.payload_bits
    wires, ports, sides = [], [], []
    for node in range(words.links):
        low = node * link
        wires.append(f"  wire o_{node}_valid;\n  wire [{payload - 1}:0] o_{node}_payload;\n"
                     f"  wire [{words.channels - 1}:0] o_credit_{node};\n")
        ports.append(f"    .i_{node}_valid(i[{low}]), .i_{node}_payload(i[{low + payload}:{low + 1}]), "
                     f".i_credit_{node}(i[{low + link - 1}:{low + payload + 1}]),\n"
                     f"    .o_{node}_valid(o_{node}_valid), .o_{node}_payload(o_{node}_payload), "
                     f".o_credit_{node}(o_credit_{node})")
        sides.append(f"o_credit_{node}, o_{node}_valid ? o_{node}_payload : {payload}'h0, o_{node}_valid")
    return (f"// {module} with its links in two words: of each valid, payload and credits, the first one lowest.\n\n"
            f"module words (input clk, input rst, input [{width - 1}:0] i, output [{width - 1}:0] o);\n"
            + "".join(wires)
            + f"  {module} network (.clk(clk), .rst(rst),{counters}\n" + ",\n".join(ports) + ");\n"
            + "  assign o = {" + ",\n    ".join(reversed(sides)) + "};\nendmodule\n")


def _network_module(module, name, topology: Topology, words: LinkWords):
    """Routers and the links between them; ports without a link receive nothing."""
    payload, channels = words.payload_bits, words.channels
    head, body = [], []
    sources = {(edge.target, edge.input): (edge.source, edge.output) for edge in topology.links}
    returns = {(edge.source, edge.output): (edge.target, edge.input) for edge in topology.links}
    for node in range(topology.nodes):
        head += [f"input i_{node}_valid, input [{payload - 1}:0] i_{node}_payload, "
                 f"output [{channels - 1}:0] o_credit_{node}",
                 f"output o_{node}_valid, output [{payload - 1}:0] o_{node}_payload, "
                 f"input [{channels - 1}:0] i_credit_{node}"]
        ports = []
        for port, direction in enumerate(topology.ports):
            own = f"{node}_{port}"
            body.append(f"  wire valid_{own};\n  wire [{payload - 1}:0] payload_{own};\n"
                        f"  wire [{channels - 1}:0] credit_{own};\n")
            if port == LOCAL:
                given = f"i_{node}_valid", f"i_{node}_payload", f"i_credit_{node}"
                body.append(f"  assign o_{node}_valid = valid_{own}, o_{node}_payload = payload_{own}, "
                            f"o_credit_{node} = credit_{own};\n")
            elif (node, port) in sources:
                came, back = ("_".join(map(str, side[node, port])) for side in (sources, returns))
                given = f"valid_{came}", f"payload_{came}", f"credit_{back}"
            else:
                given = "1'b0", f"{payload}'h0", f"{channels}'h0"
            ports.append(f"    // {direction}\n    .i_{port}_valid({given[0]}), .i_{port}_payload({given[1]}), "
                         f".i_credit_{port}({given[2]}),\n    .o_{port}_valid(valid_{own}), "
                         f".o_{port}_payload(payload_{own}), .o_credit_{port}(credit_{own})")
        bits = (topology.nodes - 1).bit_length()
        body += [f"  {name} router_{node} (.clk(clk), .rst(rst), .node({bits}'d{node}), .moves(), .stalls(),\n",
                 ",\n".join(ports), ");\n"]
    return (f"// A network of {topology.nodes} routers: {topology}.\n\n"
            f"module {module} (input clk, input rst,\n  " + ",\n  ".join(head) + ");\n" + "".join(body) + "endmodule\n")
