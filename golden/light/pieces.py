"""The unknowns of the radiosity system: elements, and the pieces into which contacts cut some of them."""

import numpy as np
from scipy import sparse

from golden.cast.rays import Hits
from golden.light.contacts import PARTS, Contacts
from golden.light.elements import Elements

__all__ = ["MIDDLES", "Pieces"]

_B, _A = (grid.ravel() for grid in np.meshgrid(*[(np.arange(PARTS) + 0.5) / PARTS] * 2, indexing="ij"))
MIDDLES = np.stack([(1 - _A) * (1 - _B), _A * (1 - _B), (1 - _A) * _B, _A * _B], axis=1)
"""PARTS^2 x 4: the shares of a quadrilateral's corners in what is interpolated to the middles of its parts."""


class Pieces:
    """Elements, of which quadrilaterals with contacts are cut into parts that see the same corners: P pieces in all.

    So the two sides of a thin wall that stands on an element have light of their own.

    Parameters
    ----------
    elements
        The elements.
    contacts
        Those of the elements' lattice.

    Members
    -------
    element, area
        P each: the element of each piece, and its area.
    of_corners
        Sparse P x M: interpolation from the nodes that a piece sees to its middle, or if it sees none, from all corners
        of its element.
    is_blind
        P bool: whether the piece sees no corner of its element.
    """

    def __init__(self, elements: Elements, contacts: Contacts):
        self._elements = elements
        row = np.where(elements.triangle, -1, contacts.row[elements.position.cell])
        whole, cut = np.flatnonzero(row < 0), np.flatnonzero(row >= 0)
        sees, self._inside = contacts.sees[row[cut]], contacts.inside[row[cut]]
        kind = (sees * (1, 2, 4, 8)).sum(axis=2) + 16 * np.arange(len(cut))[:, None]
        kinds, parts = np.unique(kind, return_inverse=True)
        self._row = np.full(len(elements), -1)
        self._row[cut] = np.arange(len(cut))
        self._whole = np.zeros(len(elements), dtype=np.int64)
        self._whole[whole] = np.arange(len(whole))
        self._parts = len(whole) + parts.reshape(-1, PARTS**2)
        self._contacts, self._of_place = contacts, np.full(contacts.close.size, -1)
        self._of_place.reshape(-1, PARTS**2)[row[cut]] = self._parts
        self.element = np.concatenate([whole, cut[kinds // 16]])
        self.is_blind = np.concatenate([np.zeros(len(whole), dtype=bool), kinds % 16 == 0])
        share = np.ones(len(self.element))
        share[len(whole):] = np.bincount(parts.ravel(), minlength=len(kinds)) / PARTS**2
        self.area = elements.area[self.element] * share
        self.of_corners = sparse.vstack([elements.of_corners[whole], self._of_seen(sees, cut, len(whole))]).tocsr()

    def __len__(self) -> int:
        return len(self.element)

    def seen(self, direction: np.ndarray, hits: Hits) -> np.ndarray:
        """The pieces that rays with the directions K x 3 hit, or -1: nothing, or the back of a one-sided patch."""
        element = self._elements.seen(direction, hits)
        piece = np.where(element >= 0, self._whole[element], -1)
        some = np.flatnonzero((element >= 0) & (self._row[element] >= 0))
        own = element[some]
        position = self._elements.at(hits.patch[some], hits.u[some], hits.v[some], self._elements.front[own])
        piece[some] = self._of_place[self._contacts.places(position)]
        return piece

    def points(self, count: int) -> tuple[np.ndarray, ...]:
        """The fields of elements in which light is sampled: ``count`` x ``count``, or all parts of one that is cut.

        Returns
        -------
        Element, piece, column and row of each field, fields along each side of its element, and whether it is a part
        with its middle inside a body.
        """
        across = np.where(self._row < 0, count, PARTS)
        element = np.repeat(np.arange(len(across)), across**2)
        field = np.arange(len(element)) - np.repeat(np.cumsum(across**2) - across**2, across**2)
        row, column = np.divmod(field, across[element])
        cut, piece = self._row[element], self._whole[element]
        some = np.flatnonzero(cut >= 0)
        place, inside = (cut[some], field[some]), np.zeros(len(element), dtype=bool)
        piece[some], inside[some] = self._parts[place], self._inside[place]
        return element, piece, column, row, across[element], inside

    def of_elements(self, open_: np.ndarray) -> sparse.csr_array:
        """Sparse C x P: means over the pieces of elements, by area; of the ``open_`` ones, P bool, if there are any."""
        shape = len(self._elements), len(self)
        weight = sparse.csr_array((np.where(open_, self.area, 0.0), (self.element, np.arange(len(self)))), shape=shape)
        none = weight.sum(axis=1) == 0
        weight += sparse.csr_array((np.where(none[self.element], self.area, 0.0),
                                    (self.element, np.arange(len(self)))), shape=shape)
        return sparse.diags_array(1 / weight.sum(axis=1)) @ weight

    def _of_seen(self, sees, cut, first):
        """Interpolation to the pieces of cut elements."""
        share = MIDDLES * np.where(sees.any(axis=2, keepdims=True), sees, True)
        shape = len(self.element) - first, self._elements.of_corners.shape[1]
        rows = np.repeat((self._parts - first).ravel(), 4)
        nodes = np.repeat(self._elements.position.nodes[cut], PARTS**2, axis=0).ravel()
        total = sparse.csr_array((share.ravel(), (rows, nodes)), shape=shape)
        return sparse.diags_array(1 / total.sum(axis=1)) @ total if shape[0] else total
