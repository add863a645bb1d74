// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "slim_init/evaluation/protocol.h"

namespace slim_init::evaluation {

/// Names of the methods that ran on any of the sequences, in the order in which they first occur.
std::vector<std::string> methodsOf(const std::vector<const ProtocolResult*>& sequences);

/// Where a method stands in result.methods and in every WindowRecord::methods; -1: it did not run.
int indexOf(const ProtocolResult& result, const std::string& method);

}  // namespace slim_init::evaluation
