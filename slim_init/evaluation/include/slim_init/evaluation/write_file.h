// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Files of results.
#pragma once

#include <string>

namespace slim_init::evaluation {

/// Writes a file as a whole: beside its place under the name `path`.part, then renamed, so that
/// a reader finds the old one or the new one. Returns an empty string, or a sentence naming
/// the file; the old one is then as it was.
std::string writeFile(const std::string& path, const std::string& bytes);

/// Whether writeFile() could write there, for a check before long work; what is there stays as it
/// is. Returns an empty string or the sentence of writeFile().
std::string checkWritable(const std::string& path);

}  // namespace slim_init::evaluation
