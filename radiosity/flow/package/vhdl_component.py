"""The declaration by which a VHDL design instantiates an exported module."""

__all__ = ["vhdl_component"]


def vhdl_component(name: str, about: str, ports: list[dict]) -> str:
    """A package ``NAME_component`` with the component ``NAME``: VHDL-93.

    Parameters
    ----------
    name, about
        Of the module, and what it is in words.
    ports
        Those of the manifest: name, direction and width of each.
    """
    lines = ";\n".join(f"            {port['name']} : {port['direction'].removesuffix('put')} {_type(port['width'])}"
                       for port in ports)
    return (f"-- {about}: the component of the module {name}, whose Verilog is {name}.v.\n\n"
            "library ieee;\nuse ieee.std_logic_1164.all;\n\n"
            f"package {name}_component is\n"
            f"    component {name} is\n        port (\n{lines}\n        );\n    end component;\nend package;\n")


def _type(width):
    return "std_logic" if width == 1 else f"std_logic_vector({width - 1} downto 0)"
