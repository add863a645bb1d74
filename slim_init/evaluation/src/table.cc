// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slim_init::evaluation {
namespace {

/// Length of the UTF-8 sequence that begins at `i`; 0 where none does.
std::size_t sequenceLength(const std::string& text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const std::size_t length = byte(i) < 0x80                       ? 1
                             : byte(i) >= 0xC2 && byte(i) < 0xE0  ? 2
                             : (byte(i) & 0xF0) == 0xE0           ? 3
                             : byte(i) >= 0xF0 && byte(i) <= 0xF4 ? 4
                                                                  : 0;
  if (i + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xC0) != 0x80) return 0;
  }
  return length;
}

/// Columns of a terminal.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string withBeside(const TableCell& cell, const std::string& text) {
  return cell.beside.empty() ? text : text + " (" + cell.beside + ")";
}

std::string terminalText(const TableCell& cell) {
  return withBeside(cell, cell.best ? cell.text + "*" : cell.text);
}

}  // namespace

TableCell numberCell(const char* pattern, double value, double factor) {
  TableCell cell("-");
  if (!std::isfinite(value)) return cell;
  char text[64];
  std::snprintf(text, sizeof(text), pattern, factor * value);
  cell.text = text;
  cell.value = factor * value;
  return cell;
}

TableCell countCell(long long count) {
  TableCell cell(std::to_string(count));
  cell.value = static_cast<double>(count);
  return cell;
}

void markBest(Best best, std::size_t column, std::size_t first, std::size_t end, Table* table) {
  if (best == Best::kNone) return;
  const TableCell* winner = nullptr;
  for (std::size_t r = first; r < end; ++r) {
    const TableCell& cell = table->rows[r][column];
    if (!std::isfinite(cell.value)) continue;
    if (winner == nullptr ||
        (best == Best::kLowest ? cell.value < winner->value : cell.value > winner->value)) {
      winner = &cell;
    }
  }
  if (winner == nullptr) return;
  const std::string text = winner->text;
  const auto level = [&](const std::vector<TableCell>& row) {
    return std::isfinite(row[column].value) && row[column].text == text;
  };
  const auto begin = table->rows.begin() + static_cast<std::ptrdiff_t>(first);
  const auto stop = table->rows.begin() + static_cast<std::ptrdiff_t>(end);
  if (std::all_of(begin, stop, level)) return;
  for (auto row = begin; row != stop; ++row) (*row)[column].best = level(*row);
}

std::string markdownText(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c == '\n' || c == '\r' ? ' ' : c;
  }
  return escaped;
}

std::string htmlText(const std::string& text) {
  std::string escaped;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = sequenceLength(text, i);
    const char c = text[i];
    if (length == 0) {
      escaped += "\xEF\xBF\xBD";  // the replacement character
    } else if (length > 1) {
      escaped += text.substr(i, length);
    } else if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7F) {
      escaped += c;
    } else {
      escaped += c == '\n' || c == '\t' ? c : ' ';  // other control characters are not allowed
    }
    i += std::max<std::size_t>(length, 1);
  }
  return escaped;
}

std::string tableMarkdown(const Table& table) {
  std::string text = "|";
  for (const std::string& title : table.columns) text += " " + markdownText(title) + " |";
  text += "\n|";
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    text += c < table.text_columns ? "---|" : "---:|";
  }
  text += "\n";
  for (const auto& row : table.rows) {
    text += "|";
    for (const TableCell& cell : row) {
      const std::string bold = cell.best ? "**" : "";
      text += " " + markdownText(withBeside(cell, bold + cell.text + bold)) + " |";
    }
    text += "\n";
  }
  return text;
}

std::string tableHtml(const Table& table) {
  // Wide tables scroll on their own, so that the text around them keeps its width.
  std::string html = "<div class=\"wide\"><table>\n";
  if (!table.title.empty()) html += "<caption>" + htmlText(table.title) + "</caption>\n";
  html += "<thead><tr>";
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    html += c < table.text_columns ? "<th class=\"name\">" : "<th>";
    html += htmlText(table.columns[c]) + "</th>";
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string words = htmlText(row[c].text);
      html += c < table.text_columns ? "<td class=\"name\">" : "<td>";
      html += row[c].best ? "<b>" + words + "</b>" : words;
      if (!row[c].beside.empty()) {
        html += " <span class=\"beside\">(" + htmlText(row[c].beside) + ")</span>";
      }
      html += "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string tableText(const Table& table) {
  std::vector<std::vector<std::string>> rows = {table.columns};
  for (const auto& row : table.rows) {
    rows.emplace_back();
    for (const TableCell& cell : row) rows.back().push_back(terminalText(cell));
  }
  std::vector<std::size_t> widths(table.columns.size(), 0);
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width(row[c]));
  }
  std::string text = table.title.empty() ? "" : table.title + "\n";
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string padding(widths[c] - width(row[c]), ' ');
      line += c < table.text_columns ? "  " + row[c] + padding : "  " + padding + row[c];
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace slim_init::evaluation
