// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Icosahedral subdivision of the sphere (Fekete 1990), reduced to one direction of each antipodal
// pair.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <unordered_map>

#include "lines/constants.h"
#include "lines/vanishing_point.h"

namespace slim_init {
namespace {

using lines_constants::kMaxSubdivisions;

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;  // unit
  std::vector<std::array<int, 3>> faces;
};

// The regular icosahedron with two edges parallel to each coordinate axis. It is mirror symmetric
// in x, y and z, and so, bit by bit, is every subdivision: a vertex on the rim z = 0 has z == 0
// exactly, which is what makes the choice between antipodes there well defined.
Mesh icosahedron() {
  const double golden_ratio = 0.5 * (1.0 + std::sqrt(5.0));
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double a : {1.0, -1.0}) {
      for (const double b : {golden_ratio, -golden_ratio}) {
        Eigen::Vector3d vertex = Eigen::Vector3d::Zero();
        vertex[(axis + 1) % 3] = a;
        vertex[(axis + 2) % 3] = b;
        mesh.vertices.push_back(vertex);
      }
    }
  }
  // A face is a triple of neighbours. Neighbours are 2 apart, the next nearest vertices 3.24.
  const auto adjacent = [&mesh](int i, int j) {
    return (mesh.vertices[i] - mesh.vertices[j]).norm() < 2.5;
  };
  for (int i = 0; i < 12; ++i) {
    for (int j = i + 1; j < 12; ++j) {
      for (int k = j + 1; k < 12; ++k) {
        if (adjacent(i, j) && adjacent(j, k) && adjacent(i, k)) mesh.faces.push_back({i, j, k});
      }
    }
  }
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex.normalize();
  return mesh;
}

// Splits every face into four at the midpoints of its edges, pushed out to the sphere.
Mesh subdivide(const Mesh& coarse) {
  Mesh fine;
  fine.vertices = coarse.vertices;
  fine.faces.reserve(4 * coarse.faces.size());
  std::unordered_map<std::uint64_t, int> midpoint_of_edge;
  midpoint_of_edge.reserve(2 * coarse.faces.size());
  const auto midpoint = [&](int i, int j) {
    const auto [lower, upper] = std::minmax(i, j);
    const std::uint64_t edge =
        (static_cast<std::uint64_t>(lower) << 32) | static_cast<std::uint64_t>(upper);
    const auto [entry, is_new] =
        midpoint_of_edge.try_emplace(edge, static_cast<int>(fine.vertices.size()));
    if (is_new) {
      fine.vertices.push_back((coarse.vertices[i] + coarse.vertices[j]).normalized());
    }
    return entry->second;
  };
  for (const std::array<int, 3>& face : coarse.faces) {
    const int m01 = midpoint(face[0], face[1]);
    const int m12 = midpoint(face[1], face[2]);
    const int m20 = midpoint(face[2], face[0]);
    fine.faces.push_back({face[0], m01, m20});
    fine.faces.push_back({face[1], m12, m01});
    fine.faces.push_back({face[2], m20, m12});
    fine.faces.push_back({m01, m12, m20});
  }
  return fine;
}

// One direction of each antipodal pair: z > 0; on the rim y > 0; on the rim's ends x > 0.
bool isFrontFacing(const Eigen::Vector3d& d) {
  if (d.z() != 0.0) return d.z() > 0.0;
  if (d.y() != 0.0) return d.y() > 0.0;
  return d.x() > 0.0;
}

std::vector<Eigen::Vector3d> makeHemisphere(int subdivisions) {
  Mesh mesh = icosahedron();
  for (int level = 0; level < subdivisions; ++level) mesh = subdivide(mesh);
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(mesh.vertices.size() / 2);
  std::copy_if(mesh.vertices.begin(), mesh.vertices.end(), std::back_inserter(directions),
               isFrontFacing);
  return directions;
}

// One static per level, so that a level nobody asks for costs nothing.
template <int kSubdivisions>
const std::vector<Eigen::Vector3d>& hemisphereOfLevel() {
  static const std::vector<Eigen::Vector3d> directions = makeHemisphere(kSubdivisions);
  return directions;
}

}  // namespace

const std::vector<Eigen::Vector3d>& icosphereHemisphere(int subdivisions) {
  switch (std::clamp(subdivisions, 0, kMaxSubdivisions)) {
    case 0: return hemisphereOfLevel<0>();
    case 1: return hemisphereOfLevel<1>();
    case 2: return hemisphereOfLevel<2>();
    case 3: return hemisphereOfLevel<3>();
    case 4: return hemisphereOfLevel<4>();
    case 5: return hemisphereOfLevel<5>();
    default: return hemisphereOfLevel<kMaxSubdivisions>();
  }
}

}  // namespace slim_init
