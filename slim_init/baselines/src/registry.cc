// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "compared_methods.h"
#include "slim_init/baselines/baselines.h"

namespace slim_init::baselines {
namespace {

/// A compared method with the options of all methods and those that only compared ones have.
class ComparedSolver : public WindowSolver {
 public:
  ComparedSolver(const Method& method, const InitializerOptions& options,
                 const BaselineOptions& baseline_options)
      : method_(method), options_(options), baseline_options_(baseline_options) {}
  const std::string& name() const override { return method_.name; }
  InitResult solveWindow(const InitWindow& window, const SolveRequest& /*request*/,
                         WorkBudget* /*budget*/) const override {
    return method_.solve(window, options_, baseline_options_);
  }

 private:
  Method method_;
  InitializerOptions options_;
  BaselineOptions baseline_options_;
};

}  // namespace

const std::vector<Method>& methods() {
  static const std::vector<Method> kMethods = {
      {"slim", "this project's pipeline: reverse alignment, structureless refinement, own gates",
       nullptr},
      {"slim-paper", "SLIM-init as its paper writes it: points, vanishing points and lines",
       &solveSlimPaper},
      {"drt-l", "He et al. 2023, decoupled rotation and translation, loosely coupled", &solveDrtL},
      {"drt-t", "He et al. 2023, decoupled rotation and translation, tightly coupled", &solveDrtT},
      {"drt-vi-ba", "Song et al. 2025, structureless visual-inertial bundle adjustment after DRT",
       &solveDrtViBa},
  };
  return kMethods;
}

std::vector<std::string> namesOf(const std::vector<Method>& methods) {
  std::vector<std::string> names;
  for (const Method& method : methods) names.push_back(method.name);
  return names;
}

std::unique_ptr<WindowSolver> makeMethod(const std::string& name, const InitializerOptions& options,
                                         const BaselineOptions& baseline_options,
                                         std::string* error, const std::vector<Method>& known) {
  std::string message = options.validate();
  if (message.empty()) {
    for (const Method& method : known) {
      if (method.name != name) continue;
      if (method.solve == nullptr) return makeSlimSolver(options, nullptr);
      return std::make_unique<ComparedSolver>(method, options, baseline_options);
    }
    message = "unknown method \"" + name + "\", must be one of:";
    for (const Method& method : known) message += " " + method.name;
  }
  if (error != nullptr) *error = message;
  return nullptr;
}

std::unique_ptr<IInitializer> makeInitializer(const std::string& name,
                                              const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error) {
  std::unique_ptr<WindowSolver> solver = makeMethod(name, options, {}, error);
  if (solver == nullptr) return nullptr;
  return slim_init::makeInitializer(std::move(solver), calibration, options, error);
}

}  // namespace slim_init::baselines
