// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "tracks_options.h"

namespace slim_init::tools {

std::vector<AbOption> tracksOptionTable(TracksOptions* options) {
  TracksOptions& o = *options;
  return {
      {"asl", &o.asl, "DIR",
       "Sequence in ASL layout; with DIR/scene.json and ground truth errors are measured", ""},
      {"config", &o.config_file, "FILE",
       "YAML file with camera, extrinsic, td and section slim_init: (default: the sensor.yaml "
       "files beside the data)",
       ""},
      {"options", &o.options_file, "FILE",
       "YAML file whose section slim_init: takes precedence over --config's", ""},
      {"stride", &o.stride, "N", "Take every N-th image", "", 1, 1000},
      {"limit", &o.limit, "N", "Stop after this many images (0: no limit)", "", 0, 1000000000},
      {"interval", &o.interval_s, "X", "Time between keyframes [s]", "", 0.01, 100.0},
      {"out", &o.out, "DIR",
       "Folder for tracks.json, frames.csv, points.csv and lines.csv (default: nothing is written)",
       ""},
      {"quiet", &o.quiet, "", "No progress bar and no table", ""},
  };
}

std::string checkTracksOptions(const TracksOptions& o) {
  if (o.asl.empty()) return "--asl DIR is needed";
  return "";
}

}  // namespace slim_init::tools
