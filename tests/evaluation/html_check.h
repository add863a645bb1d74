// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cctype>
#include <set>
#include <string>
#include <vector>

namespace slim_init {

/// What is wrong with a document of ours: a tag that is not closed, or closed in the wrong place, a
/// "<" that opens none, something to be fetched from elsewhere. Empty where all is well.
inline std::string htmlProblem(const std::string& html) {
  static const std::set<std::string> kAlone = {"meta", "img", "br", "!DOCTYPE"};
  for (const char* fetched : {"src=\"http", "href=\"http", "<script", "<link", "url("}) {
    if (html.find(fetched) != std::string::npos) return std::string("holds ") + fetched;
  }
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    const std::string tag = html.substr(at + 1, end == std::string::npos ? 20 : end - at - 1);
    if (end == std::string::npos) return "<" + tag + " has no end";
    const bool closes = tag[0] == '/';
    const std::string name = tag.substr(closes ? 1 : 0, tag.find(' ') - (closes ? 1 : 0));
    if (name.empty() ||
        (std::isalpha(static_cast<unsigned char>(name[0])) == 0 && name[0] != '!')) {
      return "a < at " + html.substr(at, 20);
    }
    if (closes) {
      if (open.empty() || open.back() != name) {
        return "</" + name + "> closes " + (open.empty() ? "nothing" : "<" + open.back() + ">");
      }
      open.pop_back();
    } else if (kAlone.count(name) == 0) {
      open.push_back(name);
    }
    at = end;
  }
  return open.empty() ? "" : "<" + open.back() + "> is not closed";
}

}  // namespace slim_init
