"""The headers of packets: what their first flits begin with, from the lowest bits."""

from amaranth.lib.data import StructLayout

from golden.engine.config import Config
from hw.formats import Formats

__all__ = ["packet_headers"]


def packet_headers(config: Config, nodes: int) -> dict[str, StructLayout]:
    """Those of a request for a patch, and of a reply, which has the patch' surface too.

    Parameters
    ----------
    config
        The configuration.
    nodes
        Of the network.
    """
    formats, address = Formats(config), (nodes - 1).bit_length()
    request = {"destination": address, "source": address, "patch": formats.patch}
    return {"request": StructLayout(request), "reply": StructLayout({**request, "surface": formats.surface})}
