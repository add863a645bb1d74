// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "compared_methods.h"
#include "slim_init/baselines/baselines.h"

namespace slim_init::baselines {

const std::vector<Method>& allMethods() {
  static const std::vector<Method> kMethods = [] {
    std::vector<Method> all = methods();
    all.push_back({"vins", "the structure-from-motion initializer of VINS-Mono, Qin and Shen 2017",
                   &solveVins});
    all.push_back({"openvins", "the dynamic initializer of OpenVINS, Dong-Si and Mourikis 2012",
                   &solveOpenVins});
    return all;
  }();
  return kMethods;
}

}  // namespace slim_init::baselines
