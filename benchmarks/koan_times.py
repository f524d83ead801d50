"""The source's times of KOAN and of its forerunner, and closed forms of them."""

__all__ = ["TABLE_3", "TABLE_4", "closed_3", "closed_4", "errors"]

TABLE_4 = {
    "Teapot": {1: 5927, 2: 2964, 4: 1483, 8: 743, 16: 372, 32: 187},
    "Mountain": {1: 11042, 2: 5525, 4: 2766, 8: 1384, 16: 697, 32: 351},
    "Rings4": {4: 6075, 8: 2858, 16: 1413, 32: 704}}
"""By scene and nodes: seconds with pages of 4 KB and caches of 2 MB, in the operating system."""

TABLE_3 = {
    "Teapot": {1: 11522, 2: 5997, 4: 3092, 8: 1565, 16: 786, 32: 395, 64: 200},
    "Mountain": {1: 17103, 2: 9038, 4: 4626, 8: 2350, 16: 1185, 32: 600, 64: 307}}
"""By scene and nodes: seconds with pages of 1 KB, in the program itself."""

PAGES_4 = {"Teapot": 199, "Mountain": 508}
PAGES_3 = {"Teapot": 793, "Mountain": 2031}
"""Pages of the source's scenes, of 4 KB and of 1 KB."""

_FAULT, _REMOTE, _LIBRARY_FAULT = 0.011, {"Teapot": 0.09, "Mountain": 0.108}, 0.0055


def closed_4(scene: str, nodes: int, fault: float = _FAULT) -> float:
    """Seconds of table 4, if each node fetches each page of another home once, in ``fault`` seconds."""
    return TABLE_4[scene][1] / nodes + fault * PAGES_4[scene] * (nodes - 1) / nodes


def closed_3(scene: str, nodes: int) -> float:
    """Seconds of table 3, if references to other homes slow a node down too."""
    remote = (nodes - 1) / nodes
    return TABLE_3[scene][1] / nodes * (1 + _REMOTE[scene] * remote) + _LIBRARY_FAULT * PAGES_3[scene] * remote


def errors(table: dict[int, float], seconds: dict[int, float]) -> dict[int, float]:
    """Of each number of nodes but 1: seconds over the source's, less 1."""
    return {nodes: seconds[nodes] / time - 1 for nodes, time in table.items() if nodes > 1}
