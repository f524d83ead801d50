"""The example of a unit with streams: items are given and required in steps, and requests are answered."""

from golden.base.errors import InputError
from golden.engine.config import Config
from hw.lib.inspection import inspect
from radiosity.flow.package.example.cluster_script import cluster_script
from radiosity.flow.package.example.ctu_script import ctu_script
from radiosity.flow.package.example.icu_script import icu_script
from radiosity.flow.package.example.stream_script import STEP_BITS, Script
from radiosity.flow.package.example.templates import example_files
from radiosity.flow.package.port_names import port_name
from radiosity.flow.package.tops import TOPS

__all__ = ["SCRIPTS", "stream_example"]

# By `TOPS`: the script of the unit's example.
SCRIPTS = {"icu": icu_script, "ctu": ctu_script, "cluster": cluster_script}


def stream_example(top: str, name: str, config: Config) -> dict[str, str]:
    """The contents of the files by their paths in the folder of the core; none if the unit is too small for them.

    Parameters
    ----------
    top, name
        One of `SCRIPTS`, and the name of its module.
    config
        The configuration.
    """
    try:
        script = inspect(lambda: TOPS[top].make(config), lambda unit: SCRIPTS[top](unit, config))
    except InputError:
        return {}
    files = example_files("stream", {**_verilog_words(script), **_python_words(script), "NAME": name,
                                     "MAKE_SOURCES": f"../{name}.v"})
    for stream, one in script.streams.items():
        # A payload without bits has one in the file.
        width = max(one.width, 1)
        files[f"example/{stream}.hex"] = _hex(STEP_BITS + width, [
            step << width | bits for step, bits, _ in one.items]) if one.is_input else _hex(STEP_BITS + 2 * width, [
                (step << width | mask) << width | bits for step, bits, mask in one.items])
    for one in script.responders:
        files[f"example/{one.request.stream}.hex"] = _hex(one.request.width + one.answer.width, [
            request << one.answer.width | bits for request, bits in one.pairs])
    return files


def _hex(width, words):
    return "".join(f"{word:0{-(-width // 4)}x}\n" for word in words)


def _verilog_words(script: Script):
    wires, instances, connections, done, came, wrong, required = [], [], [], [], [], [], 0

    def stream(one):
        """Wires and connections of its ports; without back-pressure it is always ready."""
        name = one.stream
        wires.append(f"  wire {name}_valid;\n  wire {f'[{max(one.width, 1) - 1}:0] '}{name}_payload;\n"
                     f"  wire {name}_ready{'' if one.has_ready else ' = 1'};\n")
        parts = ["valid", *(["payload"] if one.width else []), *(["ready"] if one.has_ready else [])]
        connections.extend(f".{name}_{part}({name}_{part})" for part in parts)

    for number, (name, one) in enumerate(script.streams.items()):
        stream(one)
        kind = "source" if one.is_input else "sink"
        more = "" if one.is_input else (f", .ANY_ORDER({int(one.any_order)}), .STALLS({int(one.has_ready)})")
        ready = f"{name}_ready" if one.is_input or one.has_ready else ""
        outputs = "" if one.is_input else f", .over(over), .came({name}_came), .wrong({name}_wrong)"
        wires.append(f"  wire {name}_done;\n" + ("" if one.is_input else f"  wire [31:0] {name}_came, {name}_wrong;\n"))
        instances.append(
            f"  {kind} #(.WIDTH({max(one.width, 1)}), .COUNT({len(one.items)}), .SEED({4711 + number}){more},\n"
            f"    .FILE(\"{name}.hex\")) {name} (\n    .clk(clk), .rst(rst), .step(step), .valid({name}_valid), "
            f".payload({name}_payload), .ready({ready}),\n    .done({name}_done){outputs});\n")
        done.append(f"{name}_done")
        if not one.is_input:
            came.append(f"{name}_came")
            wrong.append(f"{name}_wrong")
            required += len(one.items)
    for one in script.responders:
        request, answer = one.request.stream, one.answer.stream
        for each in one.request, one.answer:
            stream(each)
        wires.append(f"  wire [31:0] {request}_wrong;\n")
        wrong.append(f"{request}_wrong")
        instances.append(
            f"  responder #(.KEY({one.request.width}), .WIDTH({one.answer.width}), .COUNT({len(one.pairs)}),\n"
            f"    .FILE(\"{request}.hex\")) {request} (\n    .clk(clk), .rst(rst), .valid({request}_valid), "
            f".request({request}_payload), .ready({f'{request}_ready' if one.request.has_ready else ''}),\n"
            f"    .answer_valid({answer}_valid), .answer({answer}_payload), .answer_ready({answer}_ready), "
            f".wrong({request}_wrong));\n")
    unchanged = {port_name(port): value for port, value in script.unchanged.items()}
    for port, (is_input, width) in script.ports.items():
        if is_input:
            connections.append(f".{port}({width}'h{script.constants.get(port, 0):x})")
        elif port in unchanged:
            wires.append(f"  wire [{width - 1}:0] {port};\n")
            connections.append(f".{port}({port})")
        else:
            connections.append(f".{port}()")
    return {"WIRES": "".join(wires), "INSTANCES": "\n".join(instances), "DONE": ", ".join(done),
            "CAME": " + ".join(came), "WRONG": " + ".join(wrong), "LAST": str(script.step), "REQUIRED": str(required),
            "CONNECTIONS": "".join(f",\n    {one}" for one in connections),
            "UNCHANGED": "".join(f" && {port} === {value}" for port, value in unchanged.items())}


def _python_words(script: Script):
    def table(is_input):
        return _list((name, one.width, one.has_ready, one.any_order) for name, one in script.streams.items()
                     if one.is_input == is_input)

    constants = {port: script.constants.get(port, 0) for port, (is_input, _) in script.ports.items() if is_input}
    return {"GIVEN": table(True), "REQUIRED_STREAMS": table(False), "CONSTANTS": repr(constants),
            "UNCHANGED_PORTS": repr({port_name(port): value for port, value in script.unchanged.items()}),
            "RESPONDERS": _list((
                one.request.stream, one.answer.stream, one.request.width, one.answer.width, one.request.has_ready,
                one.answer.has_ready) for one in script.responders)}


def _list(rows):
    return "[" + "".join(f"\n    {row!r}," for row in rows) + "\n]"
