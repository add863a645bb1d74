// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Runs a fuzz target without a fuzzer: on every file of a folder, on mutations of each and on
// random bytes, the same ones every time.
//   fuzz_NAME_test FOLDER COUNT     COUNT mutations of each file and as many random inputs
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "fuzz_target.h"

namespace {

using Input = std::vector<std::uint8_t>;

Input readFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return Input(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

std::size_t draw(std::mt19937_64* random, std::size_t bound) {
  return bound == 0 ? 0 : (*random)() % bound;
}

// One to four changes: a byte, a piece cut out, repeated or taken from elsewhere, the end cut off.
Input mutated(Input input, std::mt19937_64* random) {
  static const std::string kWords[] = {
      "nan", "-inf", "1e999", "-1", "[", "\n", std::string(1, '\0'), "%YAML:1.0"};
  const int changes = 1 + static_cast<int>(draw(random, 4));
  for (int change = 0; change < changes; ++change) {
    const std::size_t at = draw(random, input.size());
    const std::size_t length = std::min(input.size() - at, 1 + draw(random, 40));
    const auto begin = input.begin() + static_cast<std::ptrdiff_t>(at);
    const auto end = begin + static_cast<std::ptrdiff_t>(length);
    switch (draw(random, 6)) {
      case 0:
        if (!input.empty()) input[at] = static_cast<std::uint8_t>((*random)());
        break;
      case 1:
        if (!input.empty()) input[at] ^= static_cast<std::uint8_t>(1u << draw(random, 8));
        break;
      case 2: input.erase(begin, end); break;
      case 3: {
        const Input piece(begin, end);
        const auto where = input.begin() + static_cast<std::ptrdiff_t>(draw(random, input.size()));
        input.insert(where, piece.begin(), piece.end());
        break;
      }
      case 4: {
        const std::string& word = kWords[draw(random, std::size(kWords))];
        input.insert(begin, word.begin(), word.end());
        break;
      }
      default: input.resize(at); break;
    }
  }
  return input;
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc == 3 ? std::atoi(argv[2]) : 0;
  if (count < 1) {
    std::cerr << argv[0] << ": FOLDER COUNT\n";
    return 2;
  }
  std::vector<std::filesystem::path> seeds;
  std::error_code no_folder;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1], no_folder)) {
    if (entry.is_regular_file()) seeds.push_back(entry.path());
  }
  std::sort(seeds.begin(), seeds.end());
  const std::string last_input = std::string(argv[0]) + ".last_input";
  int runs = 0;
  const auto run = [&runs, &last_input](const Input& input) {
    // What was running when it crashed.
    std::ofstream(last_input, std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()),
               static_cast<std::streamsize>(input.size()));
    LLVMFuzzerTestOneInput(input.data(), input.size());
    ++runs;
  };
  for (const std::filesystem::path& seed : seeds) {
    const Input input = readFile(seed);
    std::mt19937_64 random(static_cast<std::uint64_t>(input.size()) + 1);
    run(input);
    for (int m = 0; m < count; ++m) run(mutated(input, &random));
  }
  std::mt19937_64 random(1);
  for (int k = 0; k < count; ++k) {
    Input input(draw(&random, 4096));
    for (std::uint8_t& byte : input) byte = static_cast<std::uint8_t>(random());
    run(input);
  }
  std::cout << runs << " inputs, " << seeds.size() << " seeds\n";
  return 0;
}
