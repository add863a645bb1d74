// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "random.h"

#include <algorithm>
#include <cmath>

namespace slim_init::simulation {
namespace {

// Step of the splitmix64 generator (Steele, Lea and Flood 2014): spreads neighbouring seeds apart.
std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

// FNV-1a, because std::hash may differ between standard libraries.
std::uint64_t hashName(const char* name) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (; *name != '\0'; ++name) {
    hash = (hash ^ static_cast<unsigned char>(*name)) * 0x100000001b3ULL;
  }
  return hash;
}

}  // namespace

Random::Random(std::uint64_t seed, const char* stream)
    : engine_(splitmix64(splitmix64(seed) ^ hashName(stream))) {}

double Random::uniform() {
  constexpr double kStep = 1.0 / 9007199254740992.0;  // 2^-53
  return static_cast<double>(engine_() >> 11) * kStep;
}

int Random::index(int count) {
  if (count <= 1) return 0;
  return std::min(count - 1, static_cast<int>(uniform() * count));
}

double Random::gaussian() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  constexpr double kTwoPi = 6.283185307179586;
  const double radius = std::sqrt(2.0 * exponential());
  const double angle = kTwoPi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

Eigen::Vector2d Random::gaussian2() {
  const double x = gaussian();  // one statement each: the order of evaluation is part of the bytes
  const double y = gaussian();
  return {x, y};
}

Eigen::Vector3d Random::gaussian3() {
  const double x = gaussian();
  const double y = gaussian();
  const double z = gaussian();
  return {x, y, z};
}

double Random::exponential() {
  return -std::log1p(-uniform());  // 1 - uniform() is in (0, 1]
}

}  // namespace slim_init::simulation
