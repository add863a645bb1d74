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

/// Read a value; throw a Problem that names `key` where it is of another kind or not finite.
void read(const std::string& key, const cv::FileNode& node, int* value);
void read(const std::string& key, const cv::FileNode& node, double* value);
void read(const std::string& key, const cv::FileNode& node, bool* value);
void read(const std::string& key, const cv::FileNode& node, std::string* value);
void read(const std::string& key, const cv::FileNode& node, const OptionWord& value);
void read(const std::string& key, const cv::FileNode& node, const OptionField& option);

/// The value of an option as a file has it: "0.22", "1", "own".
std::string written(const OptionField& option);

/// "own, on or off".
std::string listed(const std::vector<std::string>& words);

std::string lower(std::string text);

/// Opens a YAML file; throws a Problem where that fails. On the heap: in OpenCV before 4.5.2 nodes
/// point back to the FileStorage object itself, which must therefore not move.
std::unique_ptr<cv::FileStorage> openFile(const std::string& path);

}  // namespace slim_init::config
