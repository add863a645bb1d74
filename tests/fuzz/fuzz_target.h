// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the fuzz targets share. A target is one function of bytes, LLVMFuzzerTestOneInput(): under
// libFuzzer (SLIM_INIT_FUZZ) it is driven by coverage, in the tests by replay_main.cc, which gives
// it the seeds of its folder and mutations of them.
#pragma once

#include <unistd.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <limits>
#include <string>

#include "support/folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

/// What has to hold whatever the bytes are. Ends the program, which is what a fuzzer looks for.
#define FUZZ_CHECK(condition, message)                                                            \
  do {                                                                                            \
    if (!(condition)) {                                                                           \
      std::cerr << __FILE__ << ":" << __LINE__ << ": " #condition ": " << (message) << std::endl; \
      std::abort();                                                                               \
    }                                                                                             \
  } while (false)

namespace slim_init::fuzz {

/// Values out of bytes; zeros where they are used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  bool empty() const { return left_ == 0; }

  std::uint8_t byte() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }

  /// In [0, bound); 0 where `bound` is 0.
  int below(int bound) { return bound > 0 ? byte() % bound : 0; }

  /// Mostly numbers of `size`, sometimes any number: infinities, NaN, denormals, huge ones.
  double number(double size) {
    const std::uint8_t kind = byte();
    if (kind < 240) {
      const int value = byte() | byte() << 8;
      return size * (value - 32768) / 32768.0;
    }
    switch (kind) {
      case 240: return std::numeric_limits<double>::quiet_NaN();
      case 241: return std::numeric_limits<double>::infinity();
      case 242: return -std::numeric_limits<double>::infinity();
      case 243: return std::numeric_limits<double>::max();
      case 244: return std::numeric_limits<double>::denorm_min();
      case 245: return 0.0;
      default: {
        std::uint64_t bits = 0;
        for (int i = 0; i < 8; ++i) bits = bits << 8 | byte();
        double value = 0.0;
        std::memcpy(&value, &bits, sizeof(value));
        return value;
      }
    }
  }

  Eigen::Vector3d vector(double size) {
    const double x = number(size), y = number(size), z = number(size);
    return Eigen::Vector3d(x, y, z);
  }

  /// A ray that mostly points forward; not always of unit length.
  Eigen::Vector3d ray() {
    const double x = number(1.0), y = number(1.0);
    const std::uint8_t kind = byte();
    if (kind < 230) return Eigen::Vector3d(x, y, 1.0).normalized();
    return Eigen::Vector3d(x, y, number(1.0));
  }

  std::string rest() {
    std::string text(reinterpret_cast<const char*>(data_), left_);
    data_ += left_;
    left_ = 0;
    return text;
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

/// A file with changes out of the bytes: values set, the end cut off, a piece repeated.
inline std::string edited(std::string file, Bytes* bytes) {
  const auto position = [&file, bytes]() -> std::size_t {
    const std::size_t at = bytes->byte() << 16 | bytes->byte() << 8 | bytes->byte();
    return file.empty() ? 0 : at % file.size();
  };
  for (int edits = bytes->below(12); edits > 0 && !file.empty(); --edits) {
    const int kind = bytes->below(16);
    const std::size_t at = position();
    if (kind == 0) {
      file.resize(at);
    } else if (kind == 1) {
      file.insert(at, file.substr(position(), bytes->byte()));
    } else {
      for (int i = 0, count = 1 + kind / 4; i < count && at + i < file.size(); ++i) {
        file[at + i] = static_cast<char>(bytes->byte());
      }
    }
  }
  return file;
}

/// A folder of this process.
class Folder : public slim_init::Folder {
 public:
  Folder() : slim_init::Folder("slim_init_fuzz_" + std::to_string(getpid())) {}
};

}  // namespace slim_init::fuzz
