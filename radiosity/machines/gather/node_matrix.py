"""Node matrix: the rows of the form factor matrix in the nodes, cut at nodes' bounds, with the nodes' numbers."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from radiosity.machines.common.assignment import Assignment

__all__ = ["NodeMatrix", "renumbered", "restored"]


def renumbered(factors: sparse.csr_array, assignment: Assignment) -> sparse.csr_array:
    """Rows and columns in the nodes' numbers; the entries of a row stay in their order.

    Source: Kurc 1997, section 2.5.3.
    """
    rows = factors[assignment.order]
    columns = assignment.number.astype(rows.indices.dtype)[rows.indices]
    return sparse.csr_array((rows.data, columns, rows.indptr), shape=rows.shape)


def restored(matrix: sparse.csr_array, assignment: Assignment) -> sparse.csr_array:
    """The inverse of `renumbered`."""
    rows = matrix[assignment.number]
    columns = assignment.order.astype(rows.indices.dtype)[rows.indices]
    return sparse.csr_array((rows.data, columns, rows.indptr), shape=rows.shape)


@dataclass(frozen=True, kw_only=True, eq=False)
class NodeMatrix:
    """A matrix whose entries are divided among the nodes in their order: whole rows, and parts at the nodes' bounds.

    Parameters
    ----------
    matrix
        N x N, rows and columns in the nodes' numbers.
    entries
        P + 1 int64: the first entry of each node, and M.
    rows
        P + 1 int64: the first row whose element of each vector a node owns, and N.
    """

    matrix: sparse.csr_array
    entries: np.ndarray
    rows: np.ndarray

    @classmethod
    def of_rows(cls, matrix: sparse.csr_array, bounds: np.ndarray) -> "NodeMatrix":
        """Whole rows; P + 1 ``bounds`` are the first row of each node, and N."""
        return cls(matrix=matrix, entries=matrix.indptr[bounds].astype(np.int64), rows=np.asarray(bounds))

    @property
    def nodes(self) -> int:
        """P."""
        return len(self.entries) - 1

    @property
    def entry_counts(self) -> np.ndarray:
        """P int64: entries of each node."""
        return np.diff(self.entries)

    @cached_property
    def cuts(self) -> np.ndarray:
        """First entry of each part of a row, and M: the bounds of rows, and those of nodes inside a row.

        A row without entries has one part, which is empty.
        """
        inside = self.entries[1:-1]
        inside = np.unique(inside[~np.isin(inside, self.matrix.indptr)])
        return np.sort(np.concatenate([self.matrix.indptr.astype(np.int64), inside]), kind="stable")

    @cached_property
    def part_row(self) -> np.ndarray:
        """The row of each part."""
        starts = self.cuts[:-1]
        is_first = np.ones(len(starts), dtype=bool)
        inside = np.unique(self.entries[1:-1][~np.isin(self.entries[1:-1], self.matrix.indptr)])
        is_first[np.searchsorted(starts, inside)] = False
        return np.cumsum(is_first) - 1

    @cached_property
    def part_node(self) -> np.ndarray:
        """The node of each part; an empty row is its owner's."""
        node = np.searchsorted(self.entries, self.cuts[:-1], side="right") - 1
        empty = np.diff(self.cuts) == 0
        node[empty] = np.searchsorted(self.rows, self.part_row[empty], side="right") - 1
        return node

    @cached_property
    def is_owner(self) -> np.ndarray:
        """Whether each part is its row's last one, whose node owns the row's element."""
        return np.append(self.part_row[1:] != self.part_row[:-1], True)

    @cached_property
    def part_counts(self) -> np.ndarray:
        """P int64: parts of each node."""
        return np.bincount(self.part_node, minlength=self.nodes)

    @property
    def sharers(self) -> int:
        """Most nodes that share a row."""
        return int(np.bincount(self.part_row).max())

    @cached_property
    def is_split(self) -> np.ndarray:
        """P bool: whether each node's first part belongs to a row that the node before it has begun."""
        split = np.zeros(self.nodes, dtype=bool)
        split[self.part_node[1:][~self.is_owner[:-1]]] = True
        return split

    def partial_products(self, vector: np.ndarray) -> np.ndarray:
        """The product of each part with a vector of N, in the nodes' numbers: whole rows give their bits whatever P."""
        parts = sparse.csr_array((self.matrix.data, self.matrix.indices, self.cuts.astype(self.matrix.indptr.dtype)),
                                 shape=(len(self.cuts) - 1, self.matrix.shape[1]))
        return parts @ vector

    def completed(self, partials: np.ndarray) -> np.ndarray:
        """One value of each row from those of its parts.

        Exchanges over channel 0, 1 and so on add what their two groups of nodes have of the row between them. So a row
        may have any number of parts.

        Source: Kurc 1997, section 2.6.2.
        """
        row, node, values = self.part_row, self.part_node, partials
        while len(row) > self.matrix.shape[0]:
            node = node >> 1
            first = np.append(True, (row[1:] != row[:-1]) | (node[1:] != node[:-1]))
            values = np.add.reduceat(values, np.flatnonzero(first))
            row, node = row[first], node[first]
        return values
