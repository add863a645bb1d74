// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The distance behind "did you mean ...?", for keys of files and options of programs.
#pragma once

#include <cstddef>
#include <string>

namespace slim_init {

/// Number of single-letter insertions, deletions and replacements that make `a` into `b`
/// (Levenshtein 1966).
std::size_t editDistance(const std::string& a, const std::string& b);

}  // namespace slim_init
