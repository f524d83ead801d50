"""The whole configuration."""

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass, field

from golden.base.errors import InputError
from golden.engine.config.ctu import Ctu
from golden.engine.config.icu import Icu
from golden.engine.config.memory import Memory
from golden.engine.config.memsys import Memsys
from golden.engine.config.noc import Noc
from golden.engine.config.numbers import Numbers

__all__ = ["END_BITS", "Config"]

END_BITS = 24
"""Most bits of a stored inverse distance in a list of rays."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """All parameters of the machine.

    Parameters
    ----------
    numbers, icu, ctu, memsys, memory, noc
        The parameters of each unit, see there.
    """

    numbers: Numbers = field(default_factory=Numbers)
    icu: Icu = field(default_factory=Icu)
    ctu: Ctu = field(default_factory=Ctu)
    memsys: Memsys = field(default_factory=Memsys)
    memory: Memory = field(default_factory=Memory)
    noc: Noc = field(default_factory=Noc)

    def __post_init__(self):
        if self.icu.settle_fraction > self.numbers.fraction_bits:
            raise InputError("configuration: Settle fraction (icu.settle_fraction) must be at most "
                             f"numbers.fraction_bits ({self.numbers.fraction_bits}), not {self.icu.settle_fraction!r}")
        if self.icu.shadow_bits and self.numbers.inverse.width > END_BITS:
            raise InputError(f"configuration: Stored inverse distances must have at most {END_BITS} bits in a list of "
                             f"rays (icu.shadow_bits), not {self.numbers.inverse.width}")
        if self.noc.patch_nodes and self.ctu.subshells:
            raise InputError("configuration: Patch nodes (noc.patch_nodes) must be 0 where clusters have lists of "
                             f"subshells (ctu.subshell_bits), not {self.noc.patch_nodes!r}")

    def parameters(self) -> dict[str, object]:
        """All parameters by path, for example ``icu.rays``."""
        return {f"{group.name}.{parameter.name}": getattr(getattr(self, group.name), parameter.name)
                for group in dataclasses.fields(self) for parameter in dataclasses.fields(getattr(self, group.name))}

    def for_rays(self, rays: int) -> "Config":
        """A configuration whose ray memory holds a frustum of so many rays at least."""
        return self.replace({"icu.rays": max(self.icu.rays, 1 << (rays - 1).bit_length())})

    def replace(self, changes: dict[str, object]) -> "Config":
        """A configuration with other values of the parameters named by path.

        Raises
        ------
        InputError
            A path names no parameter, or the values are out of range or contradict each other.
        TypeError
            A value is not of the parameter's type.
        """
        known = self.parameters()
        for path in changes:
            if path not in known:
                raise InputError(f"configuration: there is no parameter {path!r}; there are {', '.join(known)}",
                                 parameter="parameters")
        groups = {}
        for path, value in changes.items():
            group, name = path.split(".")
            groups.setdefault(group, {})[name] = value
        return dataclasses.replace(self, **{
            group: dataclasses.replace(getattr(self, group), **values) for group, values in groups.items()})

    def with_parameters(self, assignments: Iterable[str]) -> "Config":
        """`replace` with assignments as the command line has them, for example ``icu.rays=4096``.

        Raises
        ------
        InputError
            An assignment has no ``=``, its value is not of the parameter's type, or as `replace`.
        """
        known, changes = self.parameters(), {}
        for assignment in assignments:
            path, equals, text = assignment.partition("=")
            if not equals:
                raise InputError(f"configuration: a parameter is given as PATH=VALUE, not {assignment!r}",
                                 parameter="parameters")
            kind = type(known.get(path, ""))
            try:
                changes[path] = int(text, 0) if kind is int else kind(text)
            except ValueError:
                raise InputError(f"configuration: {path} must be of type {kind.__name__}, not {text!r}",
                                 parameter="parameters") from None
        return self.replace(changes)
