// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "slim_init/evaluation/page.h"

namespace slim_init::evaluation {
namespace {

constexpr char kStyle[] = R"(
:root { color-scheme: light dark; --line: #d0d5da; --soft: #6b7580; --head: #f3f5f7; }
@media (prefers-color-scheme: dark) {
  :root { --line: #3c444c; --soft: #9aa5b0; --head: #20262c; }
}
body { font: 15px/1.5 system-ui, sans-serif; max-width: 76em; margin: 2em auto; padding: 0 1.5em; }
h1 { font-size: 1.7em; } h2 { font-size: 1.25em; margin-top: 2.2em; }
nav ul { columns: 18em; padding-left: 1.2em; }
.wide { overflow-x: auto; margin: 1em 0; }
table { border-collapse: collapse; font-size: 0.87em; font-variant-numeric: tabular-nums; }
caption { text-align: left; font-weight: 600; padding: 0.4em 0; }
th, td { border-bottom: 1px solid var(--line); padding: 0.25em 0.7em; text-align: right;
  white-space: nowrap; }
th { background: var(--head); }
th.name, td.name { text-align: left; }
.beside { color: var(--soft); }
pre { background: var(--head); padding: 0.8em; overflow-x: auto; }
figure { margin: 1.2em 0; } figure img { max-width: 100%; background: white; }
figcaption { color: var(--soft); }
)";

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63u];
    }
  }
  return text;
}

/// Escaped, with `words between backticks` as code. A last backtick without a partner is itself.
std::string inlineHtml(const std::string& text) {
  std::string html;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t open = text.find('`', at);
    const std::size_t close = open == std::string::npos ? open : text.find('`', open + 1);
    if (close == std::string::npos) break;
    html += htmlText(text.substr(at, open - at)) + "<code>" +
            htmlText(text.substr(open + 1, close - open - 1)) + "</code>";
    at = close + 1;
  }
  return html + htmlText(text.substr(at));
}

/// Writes one block; counts the headings for their anchors.
struct HtmlWriter {
  const std::string& directory;
  std::string* html;
  int headings = 0;

  void operator()(const PageHeading& heading) {
    *html += "<h2 id=\"part-" + std::to_string(++headings) + "\">" + inlineHtml(heading.text) +
             "</h2>\n";
  }
  void operator()(const PageParagraph& paragraph) const {
    *html += "<p>" + inlineHtml(paragraph.text) + "</p>\n";
  }
  void operator()(const PageList& list) const {
    if (list.items.empty()) return;
    *html += "<ul>\n";
    for (const std::string& item : list.items) *html += "<li>" + inlineHtml(item) + "</li>\n";
    *html += "</ul>\n";
  }
  void operator()(const PageCode& code) const {
    *html += "<pre>" + htmlText(code.text) + "</pre>\n";
  }
  void operator()(const PagePicture& picture) const {
    std::ifstream file(std::filesystem::path(directory) / picture.file, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)),
                            std::istreambuf_iterator<char>());
    const std::string title = htmlText(picture.title);
    if (bytes.empty()) {
      *html += "<p>" + title + ": the picture " + htmlText(picture.file) + " cannot be read.</p>\n";
      return;
    }
    *html += "<figure><img alt=\"" + title + "\" src=\"data:image/png;base64," + base64(bytes) +
             "\"><figcaption>" + title + "</figcaption></figure>\n";
  }
  void operator()(const Table& table) const { *html += tableHtml(table); }
};

/// The headings, linked to the anchors that HtmlWriter gives them; nothing without headings.
std::string contents(const Page& page) {
  std::string items;
  int headings = 0;
  for (const PageBlock& block : page.blocks) {
    const auto* heading = std::get_if<PageHeading>(&block);
    if (heading == nullptr) continue;
    items += "<li><a href=\"#part-" + std::to_string(++headings) + "\">" +
             inlineHtml(heading->text) + "</a></li>\n";
  }
  return items.empty() ? "" : "<nav><ul>\n" + items + "</ul></nav>\n";
}

}  // namespace

std::string pageHtml(const Page& page, const std::string& directory) {
  const std::string title = htmlText(page.title);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      title + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" + title + "</h1>\n" +
      contents(page);
  HtmlWriter writer{directory, &html};
  for (const PageBlock& block : page.blocks) std::visit(writer, block);
  return html + "</body>\n</html>\n";
}

}  // namespace slim_init::evaluation
