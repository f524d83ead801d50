"""What a viewer shows first of a machine's waveforms: the ports of the engine, the clusters and their units."""

from pathlib import Path

from vcd.gtkw import GTKWSave

from golden.base.output import whole_file

__all__ = ["write_wave_view"]

_UNITS = ("traversal", "memory", "intersection")
_PINS = ("host__", "axi__", "i_", "o_")


def write_wave_view(waves: Path, view: Path) -> None:
    """Write a save file of GTKWave for a VCD file: a group for the engine, for each cluster and each of its units.

    The groups hold the streams and buses at their ports. All but the engine's group are closed at first.
    """
    with whole_file(view) as part, part.open("w", encoding="utf-8", errors="surrogateescape") as file:
        save = GTKWSave(file)
        save.dumpfile(waves.name, abspath=False)
        for number, (name, signals) in enumerate(_groups(waves).items()):
            with save.group(name, closed=number > 0):
                for signal in signals:
                    save.trace(signal)


def _groups(waves):
    """The signals of each group by its name, in the order of the file."""
    groups, path = {}, []
    with waves.open() as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["$scope"]:
                path.append(words[2])
            elif words[:1] == ["$upscope"]:
                path.pop()
            elif words[:1] == ["$enddefinitions"]:
                break
            elif words[:1] == ["$var"] and words[4].startswith(_PINS) and (name := _group(path)):
                groups.setdefault(name, []).append(".".join([*path, "".join(words[4:-1])]))
    return groups


def _group(path):
    """The group of a module's ports: the engine, a cluster, or one of its units; none of all others."""
    match path:
        case [_, "top"]:
            return "engine"
        case [_, "top", cluster]:
            return cluster if cluster.startswith("cluster_") else None
        case [_, "top", cluster, *_, unit] if cluster.startswith("cluster_") and unit in _UNITS:
            return f"{cluster} {unit}" if not set(path[3:-1]) & set(_UNITS) else None
    return None
