// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What lines do and do not say about the motion: the identities behind docs/baselines.md.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "geometry/so3.h"
#include "linear_alignment.h"

namespace slim_init::baselines {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct View {
  Matrix3d R_w_c;
  Vector3d c_w;
};

struct LineScene {
  Vector3d point_w, direction_w;
  std::vector<View> views;

  // Unit normal of the interpretation plane in the camera, from two arbitrary points of the line.
  Vector3d normal(int k) const {
    const View& v = views[k];
    const Vector3d s = v.R_w_c.transpose() * (point_w - (0.3 + 0.1 * k) * direction_w - v.c_w);
    const Vector3d e = v.R_w_c.transpose() * (point_w + (0.5 - 0.1 * k) * direction_w - v.c_w);
    return s.cross(e).normalized();
  }
};

LineScene randomScene(unsigned seed, int views) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> gaussian(0.0, 1.0);
  const auto vector = [&](double size) {
    const double x = gaussian(random), y = gaussian(random), z = gaussian(random);
    return Vector3d(size * x, size * y, size * z);
  };
  LineScene scene;
  scene.point_w = Vector3d(0, 0, 5) + vector(0.5);
  scene.direction_w = vector(1.0).normalized();
  for (int k = 0; k < views; ++k) scene.views.push_back({expSO3(vector(0.2)), vector(0.5)});
  return scene;
}

TEST(LineGeometry, Equation9IsTheBaselineAlongTheLine) {
  // n_i^T [t]x R n_j = -t . (n_i x R n_j), and n_i x R n_j is parallel to the line.
  for (unsigned seed = 0; seed < 100; ++seed) {
    const LineScene scene = randomScene(seed, 2);
    const View &a = scene.views[0], &b = scene.views[1];
    const Matrix3d R_ci_cj = a.R_w_c.transpose() * b.R_w_c;
    const Vector3d t = a.R_w_c.transpose() * (b.c_w - a.c_w);
    const Vector3d n_i = scene.normal(0), n_j = scene.normal(1);
    const Vector3d axis = n_i.cross(R_ci_cj * n_j);
    EXPECT_NEAR(lineEpipolarResidual(n_i, n_j, R_ci_cj, t), -t.dot(axis), 1e-15);
    const Vector3d d_i = a.R_w_c.transpose() * scene.direction_w;
    EXPECT_LT(axis.cross(d_i).norm(), 1e-13);
  }
}

TEST(LineGeometry, Equation9DoesNotVanishAtTheTrueMotion) {
  // The counter-example: a line ahead, the camera moving along it as in a corridor.
  LineScene scene;
  scene.point_w = Vector3d(1.0, 0.8, 4.0);
  scene.direction_w = Vector3d::UnitZ();
  // The sideways step makes the two planes differ; without it they coincide and eq. (9) is 0 = 0.
  scene.views = {{Matrix3d::Identity(), Vector3d::Zero()},
                 {Matrix3d::Identity(), Vector3d(0.1, 0.0, 1.0)}};
  const double residual = lineEpipolarResidual(scene.normal(0), scene.normal(1),
                                               Matrix3d::Identity(), Vector3d(0.1, 0.0, 1.0));
  EXPECT_GT(std::abs(residual), 0.05);
}

TEST(LineGeometry, TwoViewsOfALinePutNoConstraintOnTheMotion) {
  // Whatever the assumed motion, some 3D line explains both observations exactly.
  for (unsigned seed = 0; seed < 50; ++seed) {
    const LineScene scene = randomScene(seed, 2);
    const Vector3d n_i = scene.normal(0), n_j = scene.normal(1);
    const LineScene other = randomScene(seed + 1000, 2);  // an unrelated motion
    const Matrix3d R = other.views[0].R_w_c.transpose() * other.views[1].R_w_c;
    const Vector3d t = other.views[1].c_w - other.views[0].c_w;
    // The two planes n_i . X = 0 and (R n_j) . (X - t) = 0 meet in a line.
    Eigen::Matrix<double, 2, 3> A;
    A << n_i.transpose(), (R * n_j).transpose();
    const Eigen::Vector2d y(0.0, (R * n_j).dot(t));
    const Vector3d X = A.transpose() * (A * A.transpose()).inverse() * y;
    const Vector3d d = n_i.cross(R * n_j).normalized();
    EXPECT_NEAR(n_i.dot(X + 2.0 * d), 0.0, 1e-12);
    EXPECT_NEAR((R * n_j).dot(X + 2.0 * d - t), 0.0, 1e-12);
  }
}

TEST(LineGeometry, ThreeViewsConstrainRotationAndTranslation) {
  // With a N_i + b N_j + c N_k = 0 (the normals are coplanar, at right angles to the line)
  // a N_i . c_i + b N_j . c_j + c N_k . c_k = 0 for the camera centres.
  for (unsigned seed = 0; seed < 100; ++seed) {
    const LineScene scene = randomScene(seed, 3);
    Matrix3d N;
    for (int k = 0; k < 3; ++k) N.col(k) = scene.views[k].R_w_c * scene.normal(k);
    EXPECT_NEAR(N.determinant(), 0.0, 1e-13);
    const Eigen::JacobiSVD<Matrix3d> svd(N, Eigen::ComputeFullV);
    const Vector3d abc = svd.matrixV().col(2);
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) sum += abc[k] * N.col(k).dot(scene.views[k].c_w);
    EXPECT_NEAR(sum, 0.0, 3e-13);
    // Moving one camera off its place violates it unless it moves along the plane of that view.
    double moved = sum + abc[1] * N.col(1).dot(0.1 * N.col(1));
    EXPECT_GT(std::abs(moved), 1e-3 * std::abs(abc[1]));
  }
}

}  // namespace
}  // namespace slim_init::baselines
