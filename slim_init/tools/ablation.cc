// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The methods of a run, and what they are worth with one ingredient changed.
#include "ab_options.h"
#include "exit_code.h"
#include "methods.h"

namespace slim_init::tools {

using baselines::BaselineOptions;
namespace {

/// One way to change a method.
struct Variant {
  const char* method;    ///< "slim"
  const char* name;      ///< "no-lines", reported as "slim[no-lines]"
  const char* sentence;  ///< what is changed
  void (*change)(InitializerOptions* options, BaselineOptions* baselines);
};

/// In the order of the reports.
const Variant kVariants[] = {
    {"slim", "points-only", "neither lines nor vanishing points",
     [](InitializerOptions* o, BaselineOptions*) {
       o->refinement.use_lines = o->slim.vanishing_points = false;
     }},
    {"slim", "no-lines", "vanishing points, but no lines in the refinement",
     [](InitializerOptions* o, BaselineOptions*) { o->refinement.use_lines = false; }},
    {"slim", "no-vp", "lines, but no vanishing points",
     [](InitializerOptions* o, BaselineOptions*) { o->slim.vanishing_points = false; }},
    {"slim", "no-accel-bias", "accelerometer bias held at zero in the refinement",
     [](InitializerOptions* o, BaselineOptions*) { o->refinement.estimate_accel_bias = false; }},
    {"slim", "no-refinement", "the first start is the estimate",
     [](InitializerOptions* o, BaselineOptions*) { o->slim.refine = false; }},
    {"slim", "no-pruning", "tracks that contradict the consensus bias stay in",
     [](InitializerOptions* o, BaselineOptions*) { o->slim.prune_tracks = false; }},
    {"slim", "no-line-pruning", "lines that contradict the start stay in",
     [](InitializerOptions* o, BaselineOptions*) { o->slim.prune_lines = false; }},
    {"slim-paper", "no-vp", "without the vanishing point residual, eq. (4)",
     [](InitializerOptions*, BaselineOptions* o) { o->slim_paper.use_vp = false; }},
    {"slim-paper", "no-lines", "without both line residuals, eqs. (11) and (12)",
     [](InitializerOptions*, BaselineOptions* o) {
       o->slim_paper.use_line_epipolar = o->slim_paper.use_line_normal = false;
     }},
    {"slim-paper", "no-line-epipolar", "without eq. (11)",
     [](InitializerOptions*, BaselineOptions* o) { o->slim_paper.use_line_epipolar = false; }},
    {"slim-paper", "no-line-normal", "without eq. (12)",
     [](InitializerOptions*, BaselineOptions* o) { o->slim_paper.use_line_normal = false; }},
    {"slim-paper", "points-only", "without eqs. (4), (11) and (12)",
     [](InitializerOptions*, BaselineOptions* o) {
       auto& paper = o->slim_paper;
       paper.use_vp = paper.use_line_epipolar = paper.use_line_normal = false;
     }},
};

/// Throws where the method cannot be made with these options.
std::unique_ptr<WindowSolver> make(const std::string& name, const std::string& label,
                                   const InitializerOptions& options,
                                   const BaselineOptions& baseline_options) {
  std::string error;
  std::unique_ptr<WindowSolver> solver =
      baselines::makeMethod(name, options, baseline_options, &error, baselines::allMethods());
  check(error, label + ": ", kExitInternal);
  return solver;
}

}  // namespace

std::vector<Method> makeMethods(const AbOptions& options) {
  std::vector<Method> methods;
  for (const std::string& name : options.method_names) {
    methods.push_back({name, make(name, name, options.initializer, BaselineOptions()), ""});
    if (!options.ablation) continue;
    for (const Variant& variant : kVariants) {
      if (name != variant.method) continue;
      InitializerOptions changed = options.initializer;
      BaselineOptions changed_baselines;
      variant.change(&changed, &changed_baselines);
      const std::string label = name + "[" + variant.name + "]";
      methods.push_back({label, make(name, label, changed, changed_baselines), variant.sentence});
    }
  }
  return methods;
}

}  // namespace slim_init::tools
