// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Values of OpenCV's YAML, read with a check of their kind and written as this reader takes them.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "slim_init/option_table.h"
#include "slim_init/text.h"

namespace slim_init::config {

/// The first problem of a file, as a message that starts with the key. Thrown and caught inside
/// this library only.
struct Problem {
  std::string message;
};

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  throw Problem{slim_init::text(parts...)};
}

/// Throws "KEY is VALUE, must be WANTED".
[[noreturn]] void wrongKind(const std::string& key, const cv::FileNode& node,
                            const std::string& wanted);

/// The value of `key` in `map`, empty if it is absent. Throws "KEY is given twice": OpenCV 4.6
/// keeps both, and its operator[] gives the first without a word. A key without a value at the end
/// of a file, which OpenCV reads as the text "...", is absent.
cv::FileNode valueOf(const cv::FileNode& map, const std::string& key,
                     const std::string& prefix = "");

/// Read a value; throw a Problem that names `key` where it is of another kind or not finite.
void read(const std::string& key, const cv::FileNode& node, int* value);
void read(const std::string& key, const cv::FileNode& node, double* value);
void read(const std::string& key, const cv::FileNode& node, bool* value);
void read(const std::string& key, const cv::FileNode& node, std::string* value);
void read(const std::string& key, const cv::FileNode& node, const OptionWord& value);
void read(const std::string& key, const cv::FileNode& node, const OptionField& option);

/// The same of a key that has to be there.
template <typename T>
void readRequired(const cv::FileNode& parent, const std::string& prefix, const char* key,
                  const char* purpose, T* value) {
  const cv::FileNode node = valueOf(parent, key, prefix);
  if (node.empty()) fail(prefix, key, " is missing; it is needed for ", purpose);
  read(prefix + key, node, value);
}

/// The same of a key that may be absent.
template <typename T>
void readOptional(const cv::FileNode& root, const char* key, T* value) {
  const cv::FileNode node = valueOf(root, key);
  if (!node.empty()) read(key, node, value);
}

/// A section of the camera model that has to be there.
cv::FileNode requiredSection(const cv::FileNode& root, const char* key);

/// The value of an option as a file has it: "0.22", "1", "own".
std::string written(const OptionField& option);

/// "own, on or off".
std::string listed(const std::vector<std::string>& words);

std::string lower(std::string text);

/// Opens a YAML file; throws a Problem where that fails. On the heap: in OpenCV before 4.5.2 nodes
/// point back to the FileStorage object itself, which must therefore not move.
enum class Directive { kRequired, kOptional };  ///< the first line, %YAML:1.0
std::unique_ptr<cv::FileStorage> openFile(const std::string& path,
                                          Directive directive = Directive::kRequired);

}  // namespace slim_init::config
