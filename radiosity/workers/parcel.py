"""Objects that are sent to workers, known by their content."""

import hashlib
import io
import pickle
from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Parcel"]


@dataclass(frozen=True)
class Parcel:
    """A pickled object; parcels of equal content are equal.

    Parameters
    ----------
    digest
        SHA-256 of the content, as hexadecimal digits.
    content
        The object's bytes, with names instead of the objects that client and worker both have.
    """

    digest: str
    content: bytes = field(compare=False, repr=False)

    @classmethod
    def of(cls, value, known: Mapping[str, object]) -> "Parcel":
        """The parcel of an object, with the names of the ``known`` objects to which it refers."""
        packed = io.BytesIO()
        _Pickler(packed, known).dump(value)
        return cls(hashlib.sha256(packed.getvalue()).hexdigest(), packed.getvalue())

    def open(self, known: Mapping[str, object]):
        """A copy of the object, which refers to the ``known`` objects of this process."""
        return _Unpickler(io.BytesIO(self.content), known).load()


class _Pickler(pickle.Pickler):
    def __init__(self, file, known):
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self._names = {id(value): name for name, value in known.items()}

    def persistent_id(self, value):
        return self._names.get(id(value))


class _Unpickler(pickle.Unpickler):
    def __init__(self, file, known):
        super().__init__(file)
        self._known = known

    def persistent_load(self, name):
        return self._known[name]
