// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/page.h"

namespace slim_init::evaluation {
namespace {

/// Writes one block.
struct MarkdownWriter {
  std::string* text;

  void operator()(const PageHeading& heading) const { *text += "## " + heading.text + "\n"; }
  void operator()(const PageParagraph& paragraph) const { *text += paragraph.text + "\n"; }
  void operator()(const PageList& list) const {
    for (const std::string& item : list.items) *text += "- " + item + "\n";
  }
  void operator()(const PageCode& code) const { *text += "```\n" + code.text + "\n```\n"; }
  void operator()(const PagePicture& picture) const {
    const std::string title = markdownText(picture.title);
    *text += "![" + title + "](" + picture.file + ")\n\n" + title + "\n";
  }
  void operator()(const Table& table) const {
    if (!table.title.empty()) *text += "**" + markdownText(table.title) + "**\n\n";
    *text += tableMarkdown(table);
  }
};

}  // namespace

std::string pageMarkdown(const Page& page) {
  std::string text = "# " + page.title + "\n";
  for (const PageBlock& block : page.blocks) {
    text += "\n";
    std::visit(MarkdownWriter{&text}, block);
  }
  return text;
}

}  // namespace slim_init::evaluation
