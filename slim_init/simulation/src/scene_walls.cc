// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Objects on the walls of the built-in scenes.
#include <algorithm>

#include "scene_parts.h"

namespace slim_init::simulation {

Look posterLook(Random* random) {
  Look look;
  look.dark = random->uniform(0.05, 0.2);
  look.bright = random->uniform(0.5, 0.9);
  switch (random->index(5)) {
    case 0:
      look.pattern = Pattern::kMosaic;
      look.size_m = random->uniform(0.05, 0.18);
      break;
    case 1:
      look.pattern = Pattern::kMosaic;
      look.size_m = random->uniform(0.12, 0.3);
      break;
    case 2:
      look.pattern = Pattern::kGranite;
      look.size_m = random->uniform(0.4, 1.0);
      break;
    case 3:
      look.pattern = Pattern::kChecker;
      look.size_m = random->uniform(0.08, 0.2);
      look.angle_deg = random->uniform(0.0, 90.0);
      break;
    default:
      look.pattern = Pattern::kStripes;
      look.size_m = random->uniform(0.06, 0.2);
      look.angle_deg = random->uniform(0.0, 180.0);
      break;
  }
  return look;
}

void addPoster(SceneBuilder* b, Wall* wall) {
  Random& random = b->random;
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const double w = random.uniform(0.5, 1.4);
    const double h = random.uniform(0.5, 1.3);
    const double u = random.uniform(wall->low, wall->high - w);
    const double z = random.uniform(b->floor() + 0.5, b->ceiling() - 0.2 - h);
    if (!b->take(wall, u, u + w, z, z + h)) continue;
    const bool framed = random.uniform() < 0.6;
    if (framed) {
      const double rim = random.uniform(0.02, 0.05);
      const int frame = b->look(plain(random.uniform() < 0.5 ? 0.12 : 0.8));
      b->onWall("frame", *wall, u, u + w, z, z + h, 0.015, frame);
      b->onWall("picture", *wall, u + rim, u + w - rim, z + rim, z + h - rim, 0.018,
                b->look(posterLook(&random)));
      return;
    }
    if (random.uniform() < 0.5) {
      b->onWall("poster", *wall, u, u + w, z, z + h, 0.003, b->look(posterLook(&random)));
      return;
    }
    // A printed sheet: a pale ground, a heading, blocks of grey.
    b->onWall("sheet", *wall, u, u + w, z, z + h, 0.003, b->look(plain(0.85)));
    double top = z + h - 0.05;
    while (top - z > 0.15) {
      const double row = random.uniform(0.04, 0.22);
      double left = u + 0.05;
      while (u + w - left > 0.15) {
        const double column = std::min(random.uniform(0.1, 0.5), u + w - 0.05 - left);
        const double bottom = std::max(z + 0.05, top - row);
        const double grey = random.uniform(0.08, 0.6);
        b->onWall("print", *wall, left, left + column, bottom, top, 0.005,
                  b->look(random.uniform() < 0.3
                              ? Look{Pattern::kMosaic, grey + 0.2, 0.05, 0.06, 0.0, 0.0}
                              : plain(grey)));
        left += column + random.uniform(0.03, 0.08);
      }
      top -= row + random.uniform(0.03, 0.06);
    }
    return;
  }
}

void addDoorAt(SceneBuilder* b, const Wall& wall, double u, double leaf_brightness, DoorSign sign) {
  const double z = b->floor();
  const int frame = b->look(plain(0.18));
  const int leaf = b->look(plain(leaf_brightness));
  const int metal = b->look(plain(0.75));
  const int dark = b->look(plain(0.08));
  b->onWall("door post", wall, u, u + 0.07, z, z + 2.1, 0.035, frame);
  b->onWall("door post", wall, u + 0.93, u + 1.0, z, z + 2.1, 0.035, frame);
  b->onWall("lintel", wall, u, u + 1.0, z + 2.1, z + 2.17, 0.035, frame);
  b->onWall("door leaf", wall, u + 0.07, u + 0.93, z + 0.01, z + 2.1, 0.012, leaf);
  b->onWall("handle plate", wall, u + 0.83, u + 0.88, z + 0.92, z + 1.14, 0.018, metal);
  b->onWall("handle", wall, u + 0.73, u + 0.87, z + 1.04, z + 1.07, 0.06, dark);
  if (sign == DoorSign::kBeside) {
    const double v = u - 0.3;
    b->onWall("sign", wall, v, v + 0.2, z + 1.55, z + 1.7, 0.008, b->look(plain(0.9)));
    Random& random = b->random;
    for (int i = 0; i < 3; ++i) {
      const double g = v + 0.03 + 0.05 * i;
      const double top = random.uniform(1.63, 1.67), width = random.uniform(0.015, 0.04);
      b->onWall("sign print", wall, g, g + width, z + 1.6, z + top, 0.0095, dark);
    }
  }
}

void addDoor(SceneBuilder* b, Wall* wall) {
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const double u = b->random.uniform(wall->low, wall->high - 1.0);
    if (!b->take(wall, u, u + 1.0, b->floor(), b->floor() + 2.2)) continue;
    addDoorAt(b, *wall, u, 0.35, DoorSign::kNone);
    return;
  }
}

void addWindow(SceneBuilder* b, Wall* wall, double w, double h, double sill) {
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const double u = b->random.uniform(wall->low, wall->high - w);
    const double z = b->floor() + sill;
    if (!b->take(wall, u, u + w, z, z + h)) continue;
    const int frame = b->look(plain(0.8));
    b->onWall("window frame", *wall, u, u + w, z, z + h, 0.03, frame);
    const int pane = b->look(glowing(0.55));
    const double rim = 0.06;
    const double half_u = 0.5 * w;
    for (int i = 0; i < 2; ++i) {
      const double a = u + i * half_u + (i == 0 ? rim : 0.5 * rim);
      const double c = u + (i + 1) * half_u - (i == 0 ? 0.5 * rim : rim);
      b->onWall("pane", *wall, a, c, z + rim, z + h - rim, 0.032, pane);
    }
    b->onWall("window sill", *wall, u - 0.05, u + w + 0.05, z - 0.04, z, 0.12, frame);
    return;
  }
}

// A radiator: upright ribs between two rails.
void addRadiator(SceneBuilder* b, Wall* wall) {
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    const double w = 1.0;
    const double u = b->random.uniform(wall->low, wall->high - w);
    const double z = b->floor() + 0.12;
    if (!b->take(wall, u, u + w, z, z + 0.6)) continue;
    const int look = b->look(plain(0.72));
    for (int i = 0; i < 10; ++i) {
      const double a = u + 0.1 * i;
      const Box rib = b->wallBox(*wall, a, a + 0.06, z, z + 0.6, 0.03, 0.11);
      b->box("rib", rib.min, rib.max, look);
    }
    const Box rail = b->wallBox(*wall, u, u + w, z + 0.05, z + 0.1, 0.04, 0.1);
    b->box("rail", rail.min, rail.max, look);
    return;
  }
}

void addSkirting(SceneBuilder* b, double height, double brightness) {
  const int look = b->look(plain(brightness));
  for (const Wall& wall : b->walls) {
    b->onWall("skirting", wall, wall.low, wall.high, b->floor(), b->floor() + height, 0.015, look);
  }
}

}  // namespace slim_init::simulation
