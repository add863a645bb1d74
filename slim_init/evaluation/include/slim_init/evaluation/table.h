// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A table for people: made once, rendered as markdown, as HTML and for a terminal.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// One field of a table.
struct TableCell {
  std::string text;
  std::string beside;           ///< another's figure for the same, in brackets; empty: none
  double value = kNotComputed;  ///< what `text` says, for markBest(); NaN: takes no part
  bool best = false;            ///< shown bold

  TableCell() = default;
  TableCell(std::string words) : text(std::move(words)) {}  // NOLINT: a text is a cell
  TableCell(const char* words) : text(words) {}             // NOLINT
};

/// A number in printf's `pattern`, times `factor`; a dash where it does not exist.
TableCell numberCell(const char* pattern, double value, double factor = 1.0);
TableCell countCell(long long count);

/// Every row has as many cells as there are columns.
struct Table {
  std::string title;                 ///< for the terminal and as caption; empty: none
  std::vector<std::string> columns;  ///< titles
  std::size_t text_columns = 1;      ///< the first ones hold names, the others numbers
  std::vector<std::vector<TableCell>> rows;
};

/// Which figure of a column is the best one.
enum class Best { kNone, kLowest, kHighest };

/// Marks the best figures of `column` among the rows [first, end): several where they are shown by
/// the same text, none where all are level.
void markBest(Best best, std::size_t column, std::size_t first, std::size_t end, Table* table);

/// "|" would end a cell and a line end the table; both are replaced.
std::string markdownText(const std::string& text);
/// With the characters that HTML reserves escaped, and bytes that are not UTF-8 replaced.
std::string htmlText(const std::string& text);

std::string tableMarkdown(const Table& table);  ///< without its title
std::string tableHtml(const Table& table);      ///< <table>, with its title as caption
std::string tableText(const Table& table);      ///< title, then aligned columns; the best have a *

}  // namespace slim_init::evaluation
