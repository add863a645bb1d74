// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "openvins.h"
#include "slim_init/baselines/baselines.h"
#include "vins.h"

namespace slim_init::baselines {
namespace {

std::unique_ptr<WindowSolver> makeVins(const InitializerOptions& options,
                                       const BaselineOptions& baseline_options) {
  return std::make_unique<Vins>(baseline_options.vins, options.gates, options.window);
}

std::unique_ptr<WindowSolver> makeOpenVins(const InitializerOptions& options,
                                           const BaselineOptions& baseline_options) {
  return std::make_unique<OpenVins>(baseline_options.openvins, options.gates);
}

}  // namespace

const std::vector<Method>& allMethods() {
  static const std::vector<Method> kMethods = [] {
    std::vector<Method> all = methods();
    all.push_back({"vins", "the structure-from-motion initializer of VINS-Mono, Qin and Shen 2017",
                   &makeVins});
    all.push_back({"openvins", "the dynamic initializer of OpenVINS, Dong-Si and Mourikis 2012",
                   &makeOpenVins});
    return all;
  }();
  return kMethods;
}

}  // namespace slim_init::baselines
