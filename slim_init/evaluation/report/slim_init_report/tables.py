# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""A table for people: cells, the best figure of a column, and how wide it may be."""
import math
from dataclasses import dataclass, field

# Characters of a name before it is wrapped.
NAME_WIDTH = 18
# Room between two columns, in characters.
GAP = 2


@dataclass
class Cell:
    """One field of a table."""
    text: str
    beside: str = ""         # another's figure for the same, shown in brackets
    value: float = math.nan  # what `text` says, for mark_best(); NaN takes no part
    best: bool = False       # shown bold


def number(pattern, value, factor=1.0):
    """A cell with a number, e.g. number("%.3f", rate, 100.0); a dash where it does not exist."""
    if value is None or not math.isfinite(value):
        return Cell("-")
    return Cell(pattern % (factor * value), value=factor * value)


def count(value):
    """A cell with a whole number."""
    return Cell("%d" % value, value=float(value))


@dataclass
class Table:
    """Every row has as many cells as there are columns; the first `names` columns hold names, the
    others numbers."""
    columns: list
    rows: list = field(default_factory=list)
    names: int = 1
    title: str = ""

    def add(self, *cells):
        """Appends a row; texts become cells."""
        self.rows.append([cell if isinstance(cell, Cell) else Cell(str(cell)) for cell in cells])

    def mark_best(self, column, lowest=True, rows=None):
        """Marks the best figures of a column, in the rows with these indices (default: all).
        Several where they are shown by the same text, none where all are level."""
        cells = [self.rows[i][column] for i in (range(len(self.rows)) if rows is None else rows)]
        known = [cell for cell in cells if math.isfinite(cell.value)]
        if not known:
            return
        text = (min if lowest else max)(known, key=lambda cell: cell.value).text
        level = [cell for cell in known if cell.text == text]
        if len(level) == len(cells):
            return
        for cell in level:
            cell.best = True

    def width(self, column):
        """Minimum width of a column in characters: names and headers wrap, numbers do not."""
        header = max([len(word) for word in self.columns[column].split()] or [0])
        if column < self.names:
            longest = max([len(row[column].text) for row in self.rows] or [0])
            return max(header, min(longest, NAME_WIDTH))
        parts = [len(part) for row in self.rows
                 for part in (row[column].text, row[column].beside and "(%s)" % row[column].beside)]
        return max([header] + parts)

    def split(self, limit):
        """Tables of at most `limit` characters with about as many columns each; the names are
        repeated. A table of names alone, or one column of numbers, is not split any further."""
        widths = [self.width(column) + GAP for column in range(len(self.columns))]
        names, numbers = sum(widths[:self.names]), range(self.names, len(self.columns))
        if names + sum(widths[c] for c in numbers) <= limit:
            return [self]
        for parts in range(2, len(numbers) + 1):
            size = -(-len(numbers) // parts)
            chunks = [list(numbers)[i:i + size] for i in range(0, len(numbers), size)]
            if names + max(sum(widths[c] for c in chunk) for chunk in chunks) <= limit:
                break
        else:
            return [self] if len(numbers) < 2 else [self._part([c]) for c in numbers]
        return [self._part(chunk) for chunk in chunks]

    def _part(self, numbers):
        columns = list(range(self.names)) + numbers
        return Table([self.columns[c] for c in columns],
                     [[row[c] for c in columns] for row in self.rows], self.names, self.title)
