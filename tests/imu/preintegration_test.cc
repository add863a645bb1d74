// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/preintegration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "imu/imu_quality.h"
#include "support/gaussian.h"
#include "support/jacobian_check.h"

namespace slim_init {
namespace {

using Eigen::Vector3d;

const Vector3d kZero = Vector3d::Zero();

// Samples of given functions of time at `rate` Hz over [t_begin, t_end].
template <typename Gyro, typename Accel>
std::vector<ImuSample> sample(double t_begin, double t_end, double rate, const Gyro& gyro,
                              const Accel& accel) {
  std::vector<ImuSample> out;
  for (int k = 0;; ++k) {
    const double t = t_begin + k / rate;
    out.push_back({t, gyro(t), accel(t)});
    if (t >= t_end) return out;
  }
}

// A lively motion for the derivative tests.
Vector3d livelyGyro(double t) { return {0.8 * std::sin(3 * t), 0.5 * std::cos(2 * t), 0.7}; }
Vector3d livelyAccel(double t) { return {9.0 + std::sin(5 * t), 1.5 * std::cos(4 * t), -2.0 + t}; }

std::vector<ImuSample> livelySamples() {
  return sample(-0.01, 0.6, 200.0, livelyGyro, livelyAccel);
}

TEST(Preintegration, ConstantAccelerationWithoutRotationIsExact) {
  const Vector3d a(0.3, -2.0, 9.0);
  const auto imu = sample(
      0, 1, 100, [](double) { return kZero; }, [&](double) { return a; });
  const Preintegration pre =
      preintegrate(imu, 0.1234, 0.8765, {kZero, kZero}, ImuNoise(), PreintegrationParts::kMean);
  const double dt = 0.8765 - 0.1234;
  EXPECT_NEAR(pre.dt, dt, 1e-14);
  EXPECT_LT((pre.dv - a * dt).norm(), 1e-13);
  EXPECT_LT((pre.dp - 0.5 * a * dt * dt).norm(), 1e-13);
  EXPECT_LT((pre.dR - Eigen::Matrix3d::Identity()).norm(), 1e-15);
}

TEST(Preintegration, LinearAccelerationBetweenSamplesIsMetByInterpolation) {
  // a(t) = c t: the velocity increment of the trapezoid rule is exact, whatever the end points.
  const Vector3d c(1.0, -0.5, 2.0);
  const auto imu = sample(
      0, 1, 50, [](double) { return kZero; }, [&](double t) -> Vector3d { return c * t; });
  const double t_i = 0.203, t_j = 0.691;  // neither is a sample time
  const Preintegration pre =
      preintegrate(imu, t_i, t_j, {kZero, kZero}, ImuNoise(), PreintegrationParts::kMean);
  EXPECT_LT((pre.dv - 0.5 * c * (t_j * t_j - t_i * t_i)).norm(), 1e-13);
}

TEST(Preintegration, CircleAtConstantRateMatchesClosedForm) {
  // Specific force constant in b, body turning about z: dv and dp are integrals of cos and sin.
  const double w = 1.3, f = 2.0, T = 0.8;
  const auto imu = sample(
      0, 1, 1000, [&](double) { return Vector3d(0, 0, w); },
      [&](double) { return Vector3d(f, 0, 0); });
  const Preintegration pre =
      preintegrate(imu, 0.0, T, {kZero, kZero}, ImuNoise(), PreintegrationParts::kMean);
  const Vector3d dv(f * std::sin(w * T) / w, f * (1 - std::cos(w * T)) / w, 0);
  const Vector3d dp(f * (1 - std::cos(w * T)) / (w * w), f * (T / w - std::sin(w * T) / (w * w)),
                    0);
  constexpr double kTrapezoid1kHz = 1e-6;  // error of the rule, of order (w h)^2 f T
  EXPECT_LT((pre.dv - dv).norm(), kTrapezoid1kHz);
  EXPECT_LT((pre.dp - dp).norm(), kTrapezoid1kHz);
  EXPECT_LT((pre.dR - expSO3(Vector3d(0, 0, w * T))).norm(), 1e-13);
}

TEST(Preintegration, ErrorFallsWithTheSquareOfTheStep) {
  const auto dp = [](double rate) {
    const auto imu = sample(0.0, 0.6, rate, livelyGyro, livelyAccel);
    return preintegrate(imu, 0.0, 0.5, {kZero, kZero}, ImuNoise(), PreintegrationParts::kMean).dp;
  };
  const Vector3d reference = dp(51200);
  const double coarse = (dp(100) - reference).norm();
  const double fine = (dp(200) - reference).norm();
  EXPECT_NEAR(coarse / fine, 4.0, 0.2);
}

TEST(Preintegration, SplittingAnIntervalBetweenSamplesChangesNothing) {
  // The chain of two parts equals the whole to the second order of the sub-step at the split; with
  // the split on a sample it is exact.
  const auto imu = livelySamples();
  NavState start;
  start.t = 0.0;
  const Vector3d gravity(0, 0, -9.8);
  const auto go = [&](const NavState& s, double t) {
    return propagate(
        s, preintegrate(imu, s.t, t, {kZero, kZero}, ImuNoise(), PreintegrationParts::kMean),
        gravity);
  };
  const NavState whole = go(start, 0.5);
  const NavState on_sample = go(go(start, imu[50].t), 0.5);
  EXPECT_LT((whole.p_w_b - on_sample.p_w_b).norm(), 1e-14);
  EXPECT_LT((whole.R_w_b - on_sample.R_w_b).norm(), 1e-14);
  const NavState between = go(go(start, imu[50].t + 0.0021), 0.5);
  EXPECT_LT((whole.p_w_b - between.p_w_b).norm(), 1e-6);
}

TEST(Preintegration, PartsAgree) {
  const auto imu = livelySamples();
  const Vector3d bg(0.01, 0.02, -0.03), ba(0.1, -0.2, 0.05);
  const auto at = [&](PreintegrationParts parts) {
    return preintegrate(imu, 0.0013, 0.48, {bg, ba}, ImuNoise(), parts);
  };
  const Preintegration rotation = at(PreintegrationParts::kRotation);
  const Preintegration mean = at(PreintegrationParts::kMean);
  const Preintegration all = at(PreintegrationParts::kWithCovariance);
  EXPECT_EQ((rotation.dR - all.dR).norm(), 0.0);
  EXPECT_EQ((rotation.dR_dbg - all.dR_dbg).norm(), 0.0);
  EXPECT_EQ((mean.dp - all.dp).norm(), 0.0);
  EXPECT_EQ((mean.dp_dbg - all.dp_dbg).norm(), 0.0);
  EXPECT_EQ(mean.covariance.norm(), 0.0);
  EXPECT_GT(all.covariance.norm(), 0.0);
}

class PreintegrationDerivatives : public ::testing::Test {
 protected:
  Preintegration at(const Vector3d& bg, const Vector3d& ba) const {
    return preintegrate(imu_, 0.0013, 0.4978, {bg, ba}, ImuNoise(), PreintegrationParts::kMean);
  }
  const std::vector<ImuSample> imu_ = livelySamples();
  const Vector3d bg_ = Vector3d(0.02, -0.01, 0.07), ba_ = Vector3d(0.05, 0.1, -0.1);
};

TEST_F(PreintegrationDerivatives, AgreeWithDifferences) {
  const Preintegration pre = at(bg_, ba_);
  constexpr double kTolerance = 1e-7, kStep = 1e-5;
  const auto gyro = [&](auto value) {
    return numericJacobian([&](const Eigen::VectorXd& d) { return value(at(bg_ + d, ba_)); }, 3,
                           kStep);
  };
  const auto accel = [&](auto value) {
    return numericJacobian([&](const Eigen::VectorXd& d) { return value(at(bg_, ba_ + d)); }, 3,
                           kStep);
  };
  const auto rotation = [&](const Preintegration& p) -> Eigen::VectorXd {
    return logSO3(pre.dR.transpose() * p.dR);
  };
  const auto velocity = [](const Preintegration& p) -> Eigen::VectorXd { return p.dv; };
  const auto position = [](const Preintegration& p) -> Eigen::VectorXd { return p.dp; };
  EXPECT_TRUE(jacobiansAgree(pre.dR_dbg, gyro(rotation), kTolerance));
  EXPECT_TRUE(jacobiansAgree(pre.dv_dbg, gyro(velocity), kTolerance));
  EXPECT_TRUE(jacobiansAgree(pre.dp_dbg, gyro(position), kTolerance));
  EXPECT_TRUE(jacobiansAgree(pre.dv_dba, accel(velocity), kTolerance));
  EXPECT_TRUE(jacobiansAgree(pre.dp_dba, accel(position), kTolerance));
}

TEST_F(PreintegrationDerivatives, FirstOrderCorrectionErrsInSecondOrder) {
  const Preintegration pre = at(bg_, ba_);
  const Vector3d direction_g = Vector3d(1, -2, 1).normalized(), direction_a(0.3, 1, -0.5);
  const auto error = [&](double size) {
    const Vector3d bg = bg_ + size * direction_g, ba = ba_ + size * direction_a;
    const Preintegration exact = at(bg, ba);
    return (pre.positionAt(bg, ba) - exact.dp).norm() + (pre.velocityAt(bg, ba) - exact.dv).norm() +
           logSO3((pre.dR * expSO3(pre.dR_dbg * (bg - bg_))).transpose() * exact.dR).norm();
  };
  EXPECT_LT(error(1e-3), 2e-6);
  EXPECT_NEAR(error(2e-2) / error(1e-2), 4.0, 0.2);
}

TEST(Preintegration, CovarianceMatchesMonteCarlo) {
  ImuNoise noise;
  noise.gyro_density = 2e-3;
  noise.accel_density = 2e-2;
  const double rate = 200.0;
  const auto clean = livelySamples();
  const double t_i = 0.0, t_j = 0.5;
  const Preintegration pre =
      preintegrate(clean, t_i, t_j, {kZero, kZero}, noise, PreintegrationParts::kWithCovariance);

  Gaussian gaussian(7);
  constexpr int kRuns = 4000;
  Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Zero();
  for (int run = 0; run < kRuns; ++run) {
    auto imu = clean;
    for (ImuSample& s : imu) {
      s.gyro += noise.gyro_density * std::sqrt(rate) * gaussian.vector();
      s.accel += noise.accel_density * std::sqrt(rate) * gaussian.vector();
    }
    const Preintegration noisy =
        preintegrate(imu, t_i, t_j, {kZero, kZero}, noise, PreintegrationParts::kMean);
    Eigen::Matrix<double, 9, 1> e;
    e << logSO3(pre.dR.transpose() * noisy.dR), noisy.dv - pre.dv, noisy.dp - pre.dp;
    sum += e * e.transpose();
  }
  const Eigen::Matrix<double, 9, 9> sampled = sum / kRuns;
  // Whitened by the prediction the sampled covariance is the identity; with 4000 runs its entries
  // scatter by sqrt(2/4000) = 2 %. The rule itself loses half a sample at each end, 1 % here.
  const Eigen::Matrix<double, 9, 9> L = pre.covariance.llt().matrixL();
  const Eigen::Matrix<double, 9, 9> whitened = L.inverse() * sampled * L.inverse().transpose();
  constexpr double kScatter = 0.10;
  EXPECT_LT((whitened - Eigen::Matrix<double, 9, 9>::Identity()).cwiseAbs().maxCoeff(), kScatter);
}

// Variances of the velocity in white noise over the same time.
double widening(const std::vector<ImuSample>& samples, double t_i, double t_j) {
  const ImuNoise noise{1e-4, 1e-2};
  const auto pre =
      preintegrate(samples, t_i, t_j, {kZero, kZero}, noise, PreintegrationParts::kWithCovariance);
  return pre.covariance(3, 3) / (noise.accel_density * noise.accel_density * (t_j - t_i));
}

TEST(Preintegration, MissingSamplesWidenTheCovariance) {
  // At rest and free of gravity, so that rotation does not come in. Samples 10 ms apart.
  const auto still = [](double) { return kZero; };
  const auto whole = sample(0.0, 4.0, 100.0, still, still);
  EXPECT_NEAR(widening(whole, 1.0, 2.0), 1.0, 1e-9);
  // The step before the sample that comes late is 14 or 16 ms; the one after it is shorter.
  auto late = whole;
  late[150].t += 0.004;
  EXPECT_NEAR(widening(late, late[149].t, late[150].t), 1.0, 1e-9);
  late[150].t += 0.002;
  EXPECT_NEAR(widening(late, late[149].t, late[150].t), 4.5 * 1.6, 1e-3);
  // Three are missing; what a keyframe splits is the same in sum.
  auto gap = whole;
  gap.erase(gap.begin() + 151, gap.begin() + 154);
  EXPECT_NEAR(widening(gap, 1.5, 1.54), 4.5 * 4.0, 0.2);  // the mean interval is longer by 0.8 %
  EXPECT_NEAR(widening(gap, 1.5, 1.513), widening(gap, 1.513, 1.54), 1e-9);
  EXPECT_NEAR(widening(gap, 1.2, 1.5), 1.0, 1e-9);
}

// A vehicle that vibrates, the noise that is assumed of its samples, and some of them missing.
TEST(Preintegration, MissingSamplesOfAVibrationAreInTheCovariance) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * M_PI);
  double with = 0.0, before = 0.0;
  int count = 0;
  for (int run = 0; run < 60; ++run) {
    std::vector<double> phases(24);
    for (double& one : phases) one = phase(random);
    const auto accel = [&](double t) {
      Vector3d a(0.8 * std::sin(3.0 * t), 0.5 * std::cos(2.0 * t), 9.81);
      for (int k = 0; k < 8; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
          a[axis] += 0.7 * std::sin(2.0 * M_PI * (23.0 + 9.0 * k) * t + phases[3 * k + axis]);
        }
      }
      return a;
    };
    const auto whole = sample(
        0.0, 2.0, 200.0, [](double) { return kZero; }, accel);
    const ImuNoise noise =
        assumedImuNoise(ImuNoise{1.7e-4, 2e-3}, measureImuQuality(whole), InertialOptions());
    for (int first = 110; first < 250; first += 20) {
      auto gap = whole;
      gap.erase(gap.begin() + first, gap.begin() + first + 5);  // 30 ms without a sample
      const auto at = [&](const std::vector<ImuSample>& samples) {
        return preintegrate(samples, 0.5, 1.3, {kZero, kZero}, noise,
                            PreintegrationParts::kWithCovariance);
      };
      const Preintegration known = at(whole), bridged = at(gap);
      const double error2 = (known.dv - bridged.dv).squaredNorm() / 3.0;
      const double added = bridged.covariance(3, 3) - known.covariance(3, 3);
      with += error2 / added;
      before += error2 / (noise.accel_density * noise.accel_density * 0.03);
      ++count;
    }
  }
  EXPECT_GT(with / count, 0.2);
  EXPECT_LT(with / count, 2.0);
  EXPECT_GT(before / count, 5.0);
}

}  // namespace
}  // namespace slim_init
