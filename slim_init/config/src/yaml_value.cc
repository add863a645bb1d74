// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "yaml_value.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include "slim_init/feature_tracker_lines/yaml_document.h"

namespace slim_init::config {
namespace {

std::string shown(const cv::FileNode& node) {
  if (node.isInt()) return std::to_string(static_cast<int>(node));
  if (node.isReal()) return text(static_cast<double>(node));
  if (node.isString()) return '"' + static_cast<std::string>(node) + '"';
  if (node.isMap()) return "a section";
  return node.isSeq() ? "a list" : "empty";
}

std::string inFile(int value) { return std::to_string(value); }
std::string inFile(bool value) { return value ? "1" : "0"; }
std::string inFile(const std::string& value) { return value; }
std::string inFile(double value) {
  const std::string number = roundedText(15, value);
  // OpenCV reads "1" as a whole number; a reader should see that a fraction may stand here.
  return number.find_first_of(".en") == std::string::npos ? number + ".0" : number;
}

// OpenCV takes 10.0 for 10, and so do its hosts.
bool isWhole(const cv::FileNode& node) {
  if (!node.isReal()) return node.isInt();
  const double number = static_cast<double>(node);
  return number == std::round(number) && std::abs(number) <= std::numeric_limits<int>::max();
}

}  // namespace

void wrongKind(const std::string& key, const cv::FileNode& node, const std::string& wanted) {
  fail(key, " is ", shown(node), ", must be ", wanted);
}

cv::FileNode valueOf(const cv::FileNode& map, const std::string& key, const std::string& prefix) {
  cv::FileNode value;
  if (!map.isMap()) return value;
  bool found = false;
  for (const cv::FileNode& node : map) {
    if (lower(node.name()) != lower(key)) continue;
    if (node.name() != key) fail(prefix, node.name(), " is not a known key, must be ", key);
    if (found) fail(prefix, key, " is given twice");
    found = true;
    value = node;
  }
  const bool without_value = value.isString() && static_cast<std::string>(value) == "...";
  return without_value ? cv::FileNode() : value;
}

void read(const std::string& key, const cv::FileNode& node, int* value) {
  if (!isWhole(node)) wrongKind(key, node, "a whole number");
  *value = static_cast<int>(node);
}

void read(const std::string& key, const cv::FileNode& node, double* value) {
  if (!node.isInt() && !node.isReal()) wrongKind(key, node, "a number");
  const double number = static_cast<double>(node);
  if (!std::isfinite(number)) fail(key, " is ", shown(node), ", must be a finite number");
  *value = number;
}

// OpenCV's YAML has no booleans: 0 and 1 are numbers, the words are strings.
void read(const std::string& key, const cv::FileNode& node, bool* value) {
  if (isWhole(node)) {
    const int number = static_cast<int>(node);
    if (number == 0 || number == 1) {
      *value = number == 1;
      return;
    }
  } else if (node.isString()) {
    const std::string word = lower(static_cast<std::string>(node));
    if (word == "true" || word == "false") {
      *value = word == "true";
      return;
    }
  }
  wrongKind(key, node, "0, 1, true or false");
}

void read(const std::string& key, const cv::FileNode& node, std::string* value) {
  if (!node.isString()) wrongKind(key, node, "a text");
  *value = static_cast<std::string>(node);
}

void read(const std::string& key, const cv::FileNode& node, const OptionWord& value) {
  const std::string word = node.isString() ? static_cast<std::string>(node) : "";
  if (std::find(value.words.begin(), value.words.end(), word) == value.words.end()) {
    wrongKind(key, node, listed(value.words));
  }
  value.set(word);
}

void read(const std::string& key, const cv::FileNode& node, const OptionField& option) {
  std::visit([&](const auto& value) { read(key, node, value); }, option.value);
}

std::string written(const OptionField& option) {
  if (const auto* word = std::get_if<OptionWord>(&option.value)) return word->get();
  return std::visit(
      [](const auto& value) -> std::string {
        if constexpr (std::is_pointer_v<std::decay_t<decltype(value)>>) return inFile(*value);
        return "";
      },
      option.value);
}

std::string listed(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) list += i + 1 == words.size() ? " or " : ", ";
    list += words[i];
  }
  return list;
}

std::string lower(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return word;
}

cv::FileNode requiredSection(const cv::FileNode& root, const char* key) {
  const cv::FileNode node = valueOf(root, key);
  if (node.empty()) fail(key, " is missing; it is needed for the camera model");
  if (!node.isMap()) wrongKind(key, node, "a section of keys");
  return node;
}

std::unique_ptr<cv::FileStorage> openFile(const std::string& path, Directive directive) {
  // Tried first, because OpenCV prints to the console about a file it cannot open.
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open()) fail("the file cannot be opened");
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  constexpr char kNotYaml[] = "not a YAML file that OpenCV can read: ";
  if (text.compare(0, 3, "\xEF\xBB\xBF") == 0) fail(kNotYaml, "it begins with a byte order mark");
  const bool add = text.compare(0, 5, "%YAML") != 0;
  if (add && directive == Directive::kRequired) fail(kNotYaml, "it has to begin with %YAML:1.0");
  if (add) text = "%YAML:1.0\n" + text;
  if (const std::string why = feature_tracker_lines::whyNotOneDocument(text); !why.empty()) {
    fail(kNotYaml, why);
  }
  try {
    constexpr int kText =
        cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML;
    auto storage = std::make_unique<cv::FileStorage>(text, kText);
    if (!storage->isOpened()) fail("the file cannot be read");
    if (!storage->root().empty() && !storage->root().isMap()) fail("the file holds no keys");
    return storage;
  } catch (const cv::Exception& exception) {
    // exception.func is "(line): what", exception.err a function of the parser.
    const std::string& what = exception.func;
    const int number = std::atoi(&what[what.find('(') + 1]);
    std::istringstream lines(text);
    std::string line;
    for (int i = 0; i < number; ++i) std::getline(lines, line);
    fail(kNotYaml, "line ", add ? number - 1 : number, what.substr(what.find(')') + 1), ": ", line);
  }
}

}  // namespace slim_init::config
