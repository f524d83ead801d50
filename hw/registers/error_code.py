"""Error codes of the machine."""

from amaranth.lib import enum

from hw.ctu.subshell_generator import ListError
from hw.memsys.patches.path_fault import PathFault
from hw.memsys.port.fault import Fault
from hw.noc.network_fault import NetworkFault

__all__ = ["ABOUT", "CODE_BITS", "ENGINE", "LIST", "NETWORK", "PATH", "ErrorCode", "error_table"]

CODE_BITS = 6
# Where the codes of the units begin: those of main memory are its own.
PATH, NETWORK, LIST, ENGINE = 16, 24, 28, 32
_UNITS = ((0, Fault), (PATH, PathFault), (NETWORK, NetworkFault), (LIST, ListError))
_NAMES = {PathFault: "PATH", NetworkFault: "NETWORK", ListError: "LIST"}
_OWN = ("COMMAND", "NOT_LOADED", "SECTION", "WATCHDOG", "ABORTED", "DESCRIPTOR", "RING")
ErrorCode = enum.Enum("ErrorCode", {
    "NONE": 0,
    **{"_".join(filter(None, (_NAMES.get(unit), one.name))): first + one.value
       for first, unit in _UNITS for one in unit if one.value},
    **{name: ENGINE + k for k, name in enumerate(_OWN)}})
ABOUT = {
    "NONE": "no error",
    "READ_OUTSIDE": "an address outside the window of reads, or no multiple of a beat; of a load or of the ring",
    "WRITE_OUTSIDE": "an address outside the window of writes, or no multiple of a beat; of a completion record",
    "READ_REPLY": "main memory has answered a read with an error; of a section any error of a read, an address outside "
                  "the window too",
    "WRITE_REPLY": "main memory has answered a write with an error; of a section any error of a write, an address "
                   "outside the window too",
    "READ_TIMEOUT": "main memory has not answered a read; of a load or of the ring",
    "WRITE_TIMEOUT": "main memory has not answered a write; of a completion record",
    "READ_PROTOCOL": "main memory has answered no outstanding read, or with too many or too few beats; of a load or of "
                     "the ring",
    "WRITE_PROTOCOL": "main memory has answered no outstanding write; of a completion record",
    "IMAGE": "there is no image, or one of another version",
    "REGION": "a region outside the image, not at a multiple of 64, or of a length that it must not have",
    "POINTER": "a record points outside the table that it points into",
    "NO_RECORD": "the last hit of a section is not the last one of a row",
    "SIZE": "a record has a number that is too large for the machine: of cells along an axis, of grid "
            "rays, or the weight of a ray",
    "OVERFLOW": "the sum of the weights of a patch's rays exceeds its format",
    "PATH_CELL": "the scene has no such cell",
    "PATH_LIST": "a cell's list reaches beyond the patch lists",
    "PATH_PATCH": "a list names a patch that does not exist",
    "PATH_RESIDENCE": "the residence table names a node that does not hold the patch",
    "PATH_BUS": "a cell or a patch could not be read, or is malformed",
    "PATH_TIMEOUT": "a reply to the memory system of a cluster is outstanding for too long; ends in a reset",
    "NETWORK_CHECK": "the check bits of a flit do not match; ends in a reset",
    "NETWORK_ORDER": "a packet has a wrong number of flits; ends in a reset",
    "NETWORK_ADDRESS": "a packet has arrived at a wrong node; ends in a reset",
    "LIST_LENGTH": "a list of subshells does not fit its table",
    "LIST_PATCH": "a subshell of a patch that does not exist",
    "LIST_SHELL": "a subshell whose last shell is 0",
    "COMMAND": "the command is not possible now, or no bit is set",
    "NOT_LOADED": "a section before all regions are loaded without an error, or of more shells than are loaded",
    "SECTION": "a section without rays, not within its frustum, or with more tiles than the ray memory has",
    "WATCHDOG": "a load or a section has taken more cycles than `watchdog`; ends in a reset",
    "ABORTED": "a reset has ended the descriptor, which was not its cause",
    "DESCRIPTOR": "a number of a descriptor that it must not have, see the rules of its fields",
    "RING": "the doorbell is more than a ring ahead of `taken`; the queue halts",
}


def error_table() -> str:
    """All codes as Markdown."""
    lines = ["| code | name | means |", "|---|---|---|"]
    return "\n".join(lines + [f"| {one.value} | `{one.name}` | {ABOUT[one.name]} |" for one in ErrorCode]) + "\n"
