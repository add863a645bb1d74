// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <functional>
#include <utility>

#include "slim_init/window_solver.h"
#include "solvers/drt_l.h"
#include "solvers/drt_t.h"
#include "solvers/drt_vi_ba.h"
#include "solvers/slim.h"
#include "solvers/slim_paper.h"

namespace slim_init {
namespace {

using Maker = std::unique_ptr<WindowSolver> (*)(const InitializerOptions&);

template <typename Solver>
std::unique_ptr<WindowSolver> make(const InitializerOptions& options) {
  return std::make_unique<Solver>(options);
}

const std::vector<std::pair<std::string, Maker>>& registry() {
  static const std::vector<std::pair<std::string, Maker>> kRegistry = {
      {"slim", &make<Slim>},  {"slim-paper", &make<SlimPaper>}, {"drt-l", &make<DrtL>},
      {"drt-t", &make<DrtT>}, {"drt-vi-ba", &make<DrtViBa>},
  };
  return kRegistry;
}

}  // namespace

const std::vector<std::string>& solverNames() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const auto& entry : registry()) names.push_back(entry.first);
    return names;
  }();
  return kNames;
}

std::unique_ptr<WindowSolver> makeWindowSolver(const std::string& name,
                                               const InitializerOptions& options,
                                               std::string* error) {
  std::string sentence = options.validate();
  if (sentence.empty()) {
    for (const auto& entry : registry()) {
      if (entry.first == name) return entry.second(options);
    }
    sentence = "unknown method \"" + name + "\", known are:";
    for (const std::string& known : solverNames()) sentence += " " + known;
  }
  if (error != nullptr) *error = sentence;
  return nullptr;
}

}  // namespace slim_init
