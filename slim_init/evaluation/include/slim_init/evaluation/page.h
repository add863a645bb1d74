// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A page for people: made once, rendered as markdown and as HTML. In all texts `words between
// backticks` are code; nothing else is markup.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "slim_init/evaluation/table.h"

namespace slim_init::evaluation {

struct PageHeading {
  std::string text;
};
struct PageParagraph {
  std::string text;
};
struct PageList {
  std::vector<std::string> items;
};
/// As typed, in a block of its own.
struct PageCode {
  std::string text;
};
struct PagePicture {
  std::string file;  ///< PNG, relative to the folder of the page
  std::string title;
};

using PageBlock = std::variant<PageHeading, PageParagraph, PageList, PageCode, PagePicture, Table>;

struct Page {
  std::string title;
  std::vector<PageBlock> blocks;

  template <class Block>
  void add(Block block) {
    blocks.emplace_back(std::move(block));
  }
};

/// Pictures stay files beside the page.
std::string pageMarkdown(const Page& page);

/// One self-contained document (HTML 5) without scripts: style and pictures are inside, and its
/// headings are listed at the top. Pictures are read from `directory`; in the place of one that
/// cannot be read stands a sentence.
std::string pageHtml(const Page& page, const std::string& directory);

}  // namespace slim_init::evaluation
