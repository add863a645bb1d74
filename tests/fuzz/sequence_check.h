// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What has to hold for a recording with pixels, however damaged it is.
#pragma once

#include <cstddef>
#include <string>

#include "fuzz_target.h"
#include "slim_init/evaluation/image_sequence.h"

namespace slim_init::fuzz {

/// Opened or refused with a sentence, and so is every one of its images. `sequence` is null where
/// it was refused.
inline void checkSequence(evaluation::ImageSequence* sequence,
                          const evaluation::ReadStatus& status) {
  FUZZ_CHECK((sequence != nullptr) == status.ok(), status.message);
  FUZZ_CHECK(status.ok() || !status.message.empty(), "refused without a word");
  for (std::size_t k = 0; sequence != nullptr && k < sequence->images(); ++k) {
    std::string error;
    FUZZ_CHECK(!sequence->image(k, &error).empty() || !error.empty(), "refused without a word");
  }
}

}  // namespace slim_init::fuzz
