// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/backend/sliding_window_estimator.h"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "imu/preintegration.h"
#include "inertial_cost.h"
#include "point_tracks.h"
#include "prior.h"
#include "reprojection_cost.h"
#include "slim_init/text.h"
#include "window.h"

namespace slim_init::backend {
namespace {

// A bias that moved further than this from where its interval was integrated calls for a new
// integration; below, the first-order correction is exact to well under the noise.
constexpr double kGyroBiasRange = 1e-3;   // [rad/s]
constexpr double kAccelBiasRange = 1e-2;  // [m/s^2]

// Sizes and rules are those that Qin et al. (2018) publish for VINS-Mono.
constexpr int kIterations = 8;  // of Levenberg-Marquardt per frame
// Mean rotation-compensated motion of the tracks between the last keyframe and the frame after it,
// above which that frame becomes a keyframe [px]; fewer continued tracks make one as well.
constexpr double kMinParallaxPx = 10.0;
constexpr int kMinTracked = 20;
// On the standard deviation of a point: a track's first view is noisy too.
constexpr double kVisualNoiseFactor = 1.5;
constexpr double kCauchySigmas = 2.0;  // Cauchy scale of a reprojection, in standard deviations
// On the calibration's densities: sensors in motion are noisier than their data sheet.
constexpr double kGyroNoiseFactor = 3.0, kAccelNoiseFactor = 5.0;
// Of the order of EuRoC's ADIS16448 [rad/s^2/sqrt(Hz), m/s^3/sqrt(Hz)].
constexpr double kGyroBiasWalk = 2e-5, kAccelBiasWalk = 3e-3;
// While there is no start, frames older than this leave the window [s]: an initializer's window
// does not reach further back.
constexpr double kStartWindow = 2.2;
constexpr double kDefaultDepth = 5.0;  // of a point without parallax, as a start [m]
constexpr double kImuBuffer = 10.0;    // samples kept while there is no window [s]

constexpr int kMinViews = 2;
constexpr int kFrameSize = kPoseSize + kMotionSize;
constexpr double kInlierChi2 = 9.0;  // three standard deviations

// A link that a seed contradicts by this squared whitened residual per row holds a glitch: over a
// tenth of a second, an acceleration wrong by the order of gravity.
constexpr double kContradiction = 1e4;

// Beyond them the newest state is a failure of the estimator.
constexpr double kMaxAccelBias = 2.5;     // [m/s^2]
constexpr double kMaxGyroBias = 1.0;      // [rad/s]
constexpr double kMaxStep = 5.0;          // between two newest states [m]
constexpr double kMaxVerticalStep = 1.0;  // likewise, along gravity [m]
// Minimum fraction of the newest frame's known points that are where the window predicts them; a
// frame with fewer points than the second number is not judged.
constexpr double kMinInlierFraction = 0.5;
constexpr int kMinJudgedPoints = 10;

/// The IMU measurements between two neighbouring frames.
struct Link {
  Preintegration pre;      ///< dt is 0 where it has to be made
  double inflation = 1.0;  ///< on the covariance
};

BlockKey poseOf(const Frame& frame) { return {frame.id, BlockKind::kPose}; }
BlockKey motionOf(const Frame& frame) { return {frame.id, BlockKind::kMotion}; }

class Estimator : public SlidingWindowEstimator {
 public:
  explicit Estimator(const Calibration& calibration)
      : calibration_(calibration),
        gravity_w_(0.0, 0.0, -calibration.gravity_magnitude),
        loss_(kCauchySigmas) {
    noise_ = calibration.imu_noise;
    noise_.gyro_density *= kGyroNoiseFactor;
    noise_.accel_density *= kAccelNoiseFactor;
  }

  void addImu(const ImuSample& sample) override {
    if (!std::isfinite(sample.t) || !sample.gyro.allFinite() || !sample.accel.allFinite() ||
        (!imu_.empty() && sample.t <= imu_.back().t)) {
      return;
    }
    imu_.push_back(sample);
    if (frames_.empty()) trimImu(sample.t - kImuBuffer);
  }

  void replaceImu(const std::vector<ImuSample>& samples) override {
    if (samples.size() < 2) return;
    const auto before = [](const ImuSample& a, const ImuSample& b) { return a.t < b.t; };
    const auto first = std::lower_bound(imu_.begin(), imu_.end(), samples.front(), before);
    const auto last = std::upper_bound(first, imu_.end(), samples.back(), before);
    const auto place = imu_.erase(first, last);
    imu_.insert(place, samples.begin(), samples.end());
  }

  FrameReport addFrame(const FrameObservation& observation) override {
    FrameReport report;
    report.problem = checkFrame(observation);
    if (!report.ok()) return report;
    const bool keyframe = keyframeBeforeNewest(appendFrame(observation));
    if (seeded_) {
      optimizeAndSlide(1, keyframe, &report);
    } else {
      const bool long_enough = frames_.back()->t - frames_.front()->t >= kStartWindow;
      slide(keyframe || long_enough);
    }
    return report;
  }

  FrameReport seed(const std::vector<NavState>& states) override {
    FrameReport report;
    if (states.size() != frames_.size() || frames_.size() < 2) {
      report.problem = text(states.size(), " states for a window of ", frames_.size(),
                            " frames (must be equal, minimum 2)");
      return report;
    }
    points_.forgetDistances();
    for (std::size_t k = 0; k < states.size(); ++k) frames_[k]->set(states[k]);
    prior_ = anchorAt(*frames_.front());
    links_.clear();
    seeded_ = true;
    loosenContradictedLinks();
    // Twice: the intervals are integrated anew at the biases of the first solve.
    optimizeAndSlide(2, true, &report);
    return report;
  }

  bool seeded() const override { return seeded_; }

  std::vector<double> stamps() const override {
    std::vector<double> stamps;
    for (const auto& frame : frames_) stamps.push_back(frame->stamp);
    return stamps;
  }

  std::vector<NavState> states() const override {
    std::vector<NavState> states;
    for (std::size_t k = 0; seeded_ && k < frames_.size(); ++k) {
      states.push_back(frames_[k]->state());
    }
    return states;
  }

  NavState newest() const override { return seeded_ ? frames_.back()->state() : NavState(); }

  void overwrite(const std::vector<NavState>& states) override {
    for (std::size_t k = 0; k < std::min(states.size(), frames_.size()); ++k) {
      frames_[k]->set(states[k]);
    }
  }

  void unseed() override {
    seeded_ = false;
    prior_ = Prior();
    points_.forgetDistances();
  }

  void reset() override {
    frames_.clear();
    links_.clear();
    points_.clear();
    prior_ = Prior();
    imu_.clear();
    seeded_ = false;
  }

 private:
  std::string checkFrame(const FrameObservation& observation) const {
    const double t = observation.t + calibration_.td;
    if (!std::isfinite(t)) return "stamp of the frame is not finite";
    if (!frames_.empty() && !(t > frames_.back()->t)) {
      return text("frame at ", std::fixed, t, " s is not after the last at ", frames_.back()->t,
                  " s");
    }
    if (imu_.empty() || imu_.front().t > t || imu_.back().t < t) {
      return text("frame at ", std::fixed, t, " s lies outside the IMU data");
    }
    return "";
  }

  /// The frame, carried to its place by the IMU, and its points. Returns how many of them the frame
  /// before saw too.
  int appendFrame(const FrameObservation& observation) {
    auto frame = std::make_unique<Frame>();
    frame->id = next_id_++;
    frame->stamp = observation.t;
    frame->t = observation.t + calibration_.td;
    FrameId previous = -1;
    if (!frames_.empty()) {
      const Frame& last = *frames_.back();
      previous = last.id;
      const Preintegration link = integrate(last, *frame);
      frame->set(propagate(last.state(), link, gravity_w_));
      // Without a start there is no attitude against gravity: the gyro alone.
      if (!seeded_) {
        NavState turned = last.state();
        turned.R_w_b = turned.R_w_b * link.dR;
        frame->set(turned);
      }
      links_.push_back({link, 1.0});
    }
    frames_.push_back(std::move(frame));
    return points_.addFrame(frames_.back()->id, previous, observation.points);
  }

  /// Whether the frame before the newest is worth keeping: it moved since the keyframe before it,
  /// or tracks are running out.
  bool keyframeBeforeNewest(int tracked) const {
    const std::size_t n = frames_.size();
    if (n < 3 || tracked < kMinTracked) return true;
    const PointTracks::Parallax parallax =
        points_.parallax(*frames_[n - 3], *frames_[n - 2], calibration_);
    return parallax.tracks < kMinTracked || parallax.mean * calibration_.focal_px >= kMinParallaxPx;
  }

  void optimizeAndSlide(int rounds, bool keyframe, FrameReport* report) {
    for (int round = 0; round < rounds && report->ok(); ++round) {
      updateLinks();
      points_.triangulate(frames_, calibration_, kDefaultDepth);
      optimize(report);
    }
    if (report->ok()) {
      points_.removeBehind();
      measureFit(report);
    } else {
      unseed();
    }
    slide(keyframe);
  }

  // ---- inertial links ----

  Preintegration integrate(const Frame& i, const Frame& j) const {
    return preintegrate(imu_, i.t, j.t, {i.gyroBias(), i.accelBias()}, noise_,
                        PreintegrationParts::kWithCovariance);
  }

  /// Integrates anew where there is no link yet or its bias has moved away.
  void updateLinks() {
    links_.resize(frames_.size() - 1);
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const Frame& i = *frames_[k];
      Link& link = links_[k];
      if (link.pre.dt > 0.0 && (link.pre.gyro_bias - i.gyroBias()).norm() < kGyroBiasRange &&
          (link.pre.accel_bias - i.accelBias()).norm() < kAccelBiasRange) {
        continue;
      }
      link.pre = integrate(i, *frames_[k + 1]);
      link.pre.covariance *= link.inflation;
    }
  }

  /// A seed comes from data that were looked at twice: where it contradicts a link beyond anything
  /// that its own errors explain, the samples of that link are not to be believed. The tracks
  /// bridge it.
  void loosenContradictedLinks() {
    updateLinks();
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const std::unique_ptr<InertialCost> cost = inertialCost(k);
      Eigen::Matrix<double, 15, 1> r;
      if (cost == nullptr || !cost->Evaluate(linkBlocks(k).data(), r.data(), nullptr)) continue;
      const double contradiction = r.head<9>().squaredNorm() / 9.0;
      if (contradiction < kContradiction) continue;
      links_[k].inflation *= contradiction;
      links_[k].pre.covariance *= contradiction;
    }
  }

  std::array<double*, 4> linkBlocks(std::size_t k) const {
    return {frames_[k]->pose.data(), frames_[k]->motion.data(), frames_[k + 1]->pose.data(),
            frames_[k + 1]->motion.data()};
  }

  std::unique_ptr<InertialCost> inertialCost(std::size_t k) const {
    return InertialCost::create(links_[k].pre, frames_[k]->R_ref, frames_[k + 1]->R_ref, gravity_w_,
                                kGyroBiasWalk, kAccelBiasWalk);
  }

  // ---- the optimisation ----

  std::unique_ptr<ReprojectionCost> reprojectionCost(const PointTrack& track,
                                                     std::size_t view) const {
    return std::make_unique<ReprojectionCost>(
        *findFrame(frames_, track.views.front().frame),
        *findFrame(frames_, track.views[view].frame), calibration_, track.views.front().bearing,
        track.views[view].bearing, kVisualNoiseFactor * calibration_.sigmaBearing());
  }

  static bool isUsed(const PointTrack& track) {
    return track.estimated && track.views.size() >= kMinViews;
  }

  /// Pose and motion of every frame, then the inverse distances in use.
  std::vector<double> blocksAsOneArray() const {
    std::vector<double> x;
    for (const auto& frame : frames_) {
      x.insert(x.end(), frame->pose.begin(), frame->pose.end());
      x.insert(x.end(), frame->motion.begin(), frame->motion.end());
    }
    for (const auto& [id, track] : points_.tracks()) {
      if (isUsed(track)) x.push_back(track.inverse_distance);
    }
    return x;
  }
  void takeBlocks(const std::vector<double>& x) {
    auto value = x.begin();
    for (const auto& frame : frames_) {
      for (double& entry : frame->pose) entry = *value++;
      for (double& entry : frame->motion) entry = *value++;
    }
    for (auto& [id, track] : points_.tracks()) {
      if (isUsed(track)) track.inverse_distance = *value++;
    }
  }

  void optimize(FrameReport* report) {
    // Ceres eliminates in the order of addresses: in one array, so that equal input gives equal
    // bits.
    std::vector<double> x = blocksAsOneArray();
    ceres::Problem::Options problem_options;
    problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(problem_options);
    ceres::Solver::Options solver;
    solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    const auto block = [&](const BlockKey& key) {
      std::size_t k = 0;
      while (frames_[k]->id != key.frame) ++k;
      return x.data() + kFrameSize * k + (key.kind == BlockKind::kPose ? 0 : kPoseSize);
    };
    for (const auto& frame : frames_) {
      for (const BlockKey& key : {poseOf(*frame), motionOf(*frame)}) {
        problem.AddParameterBlock(block(key), key.size());
        solver.linear_solver_ordering->AddElementToGroup(block(key), 1);
      }
    }
    for (std::size_t k = 0; k < links_.size(); ++k) {
      std::unique_ptr<InertialCost> cost = inertialCost(k);
      if (cost == nullptr) {
        report->problem = "covariance of an IMU interval is not positive definite";
        return;
      }
      const Frame &i = *frames_[k], &j = *frames_[k + 1];
      problem.AddResidualBlock(cost.release(), nullptr, block(poseOf(i)), block(motionOf(i)),
                               block(poseOf(j)), block(motionOf(j)));
    }
    if (!prior_.empty()) {
      std::vector<double*> blocks;
      for (const BlockKey& key : prior_.blocks) blocks.push_back(block(key));
      problem.AddResidualBlock(new PriorCost(prior_, frames_), nullptr, blocks);
    }
    double* inverse_distance = x.data() + kFrameSize * frames_.size();
    for (auto& [id, track] : points_.tracks()) {
      if (!isUsed(track)) continue;
      double* host = block({track.views.front().frame, BlockKind::kPose});
      for (std::size_t v = 1; v < track.views.size(); ++v) {
        problem.AddResidualBlock(reprojectionCost(track, v).release(), &loss_, host,
                                 block({track.views[v].frame, BlockKind::kPose}), inverse_distance);
      }
      solver.linear_solver_ordering->AddElementToGroup(inverse_distance++, 0);
    }

    // The prior fills the reduced system: dense.
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    solver.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
    solver.max_num_iterations = kIterations;
    solver.function_tolerance = 1e-4;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    if (!summary.IsSolutionUsable()) {
      report->problem = "the optimisation failed: " + summary.message;
      return;
    }
    takeBlocks(x);
    for (const auto& frame : frames_) {
      if (!frame->poseVector().allFinite() || !frame->motionVector().allFinite()) {
        report->problem = "the optimisation gave a state that is not finite";
        return;
      }
      frame->rebase();
    }
  }

  /// How well the newest frame agrees with the window after the optimisation.
  void measureFit(FrameReport* report) const {
    report->newest_views = report->newest_inliers = 0;
    const Frame& newest = *frames_.back();
    for (const auto& [id, track] : points_.tracks()) {
      const std::size_t last = track.views.size() - 1;
      if (!track.estimated || last == 0 || track.views[last].frame != newest.id) continue;
      const double* parameters[] = {findFrame(frames_, track.views.front().frame)->pose.data(),
                                    newest.pose.data(), &track.inverse_distance};
      Eigen::Vector2d r;
      const bool valid = reprojectionCost(track, last)->Evaluate(parameters, r.data(), nullptr);
      ++report->newest_views;
      if (valid && r.squaredNorm() < kInlierChi2) ++report->newest_inliers;
    }
  }

  // ---- the window moves ----

  void slide(bool keyframe) {
    if (static_cast<int>(frames_.size()) < kWindowFrames) return;
    if (keyframe) {
      if (seeded_) marginalizeOldest();
      removeFrame(0);
    } else {
      const std::size_t second_newest = frames_.size() - 2;
      if (seeded_) marginalizeFromPrior(*frames_[second_newest]);
      removeFrame(second_newest);
    }
    trimImu(frames_.front()->t);
  }

  /// Turns what the oldest frame knows into the prior: its IMU factor, and the points first seen
  /// there. A point still in view keeps its later views as a point of its own, unlinked to the part
  /// that is marginalised: no view counts twice.
  void marginalizeOldest() {
    const Frame& oldest = *frames_.front();
    const Frame& next = *frames_[1];
    const FrameId newest = frames_.back()->id;
    // The anchor of a seed, on the oldest frame alone, is one more factor: no other frame has been
    // linearised with it.
    const bool is_anchor = !prior_.empty() && prior_.blocks.back().frame == oldest.id;
    Marginalization marginalization(frames_, is_anchor ? Prior() : prior_);
    if (is_anchor) marginalization.add(PriorCost(prior_, frames_), prior_.blocks);
    marginalization.add(*inertialCost(0),
                        {poseOf(oldest), motionOf(oldest), poseOf(next), motionOf(next)});
    const int kept_views = kWindowFrames / 2;
    for (auto it = points_.tracks().begin(); it != points_.tracks().end();) {
      PointTrack& track = it->second;
      const int views = static_cast<int>(track.views.size());
      if (track.views.front().frame != oldest.id || !track.estimated || views < kMinViews) {
        ++it;
        continue;
      }
      const bool in_view = track.views.back().frame == newest;
      const int used = in_view ? views - kept_views : views;
      if (used >= kMinViews) addPoint(track, used, &marginalization);
      if (in_view) {
        PointTracks::removeViews(std::max(used, 1), frames_, calibration_, &track);
        ++it;
      } else {
        it = points_.tracks().erase(it);
      }
    }
    prior_ = marginalization.eliminate({poseOf(oldest), motionOf(oldest)});
  }

  void addPoint(const PointTrack& track, int views, Marginalization* marginalization) const {
    std::vector<std::unique_ptr<ReprojectionCost>> costs;
    std::vector<Marginalization::PointView> point_views;
    for (int v = 1; v < views; ++v) {
      costs.push_back(reprojectionCost(track, static_cast<std::size_t>(v)));
      point_views.push_back({costs.back().get(),
                             {track.views.front().frame, BlockKind::kPose},
                             {track.views[v].frame, BlockKind::kPose}});
    }
    marginalization->addPoint(point_views, track.inverse_distance, loss_);
  }

  void marginalizeFromPrior(const Frame& frame) {
    for (const BlockKey& key : prior_.blocks) {
      if (key.frame != frame.id) continue;
      prior_ = Marginalization(frames_, prior_).eliminate({poseOf(frame), motionOf(frame)});
      return;
    }
  }

  void removeFrame(std::size_t index) {
    points_.removeFrame(frames_[index]->id, frames_, calibration_);
    frames_.erase(frames_.begin() + static_cast<std::ptrdiff_t>(index));
    // The link before and the link after become one, which is integrated when it is needed.
    double inflation = 1.0;
    if (index < links_.size()) {
      inflation = links_[index].inflation;
      links_.erase(links_.begin() + static_cast<std::ptrdiff_t>(index));
    }
    if (index > 0 && index - 1 < links_.size()) {
      Link& merged = links_[index - 1];
      merged = {Preintegration(), std::max(merged.inflation, inflation)};
    }
  }

  /// Keeps the last sample at or before t.
  void trimImu(double t) {
    const auto after = std::upper_bound(imu_.begin(), imu_.end(), t,
                                        [](double time, const ImuSample& s) { return time < s.t; });
    // Seldom: erasing from the front moves all the rest.
    if (after - imu_.begin() > 512) imu_.erase(imu_.begin(), std::prev(after));
  }

  Calibration calibration_;
  ImuNoise noise_;
  Eigen::Vector3d gravity_w_;
  ceres::CauchyLoss loss_;

  std::vector<ImuSample> imu_;
  Frames frames_;
  std::vector<Link> links_;  ///< between neighbouring frames
  PointTracks points_;
  Prior prior_;  ///< from a seed until its first frame is marginalised, anchorAt() that frame
  FrameId next_id_ = 0;
  bool seeded_ = false;
};

}  // namespace

std::unique_ptr<SlidingWindowEstimator> SlidingWindowEstimator::make(
    const Calibration& calibration) {
  return std::make_unique<Estimator>(calibration);
}

std::string detectFailure(const NavState& previous, const NavState& current,
                          const FrameReport& report) {
  const Eigen::Vector3d step = current.p_w_b - previous.p_w_b;
  // Written so that a value that is not finite fails.
  if (!(current.accel_bias.norm() <= kMaxAccelBias)) {
    return text("accelerometer bias ", current.accel_bias.norm(), " m/s^2 (limit ", kMaxAccelBias,
                ")");
  }
  if (!(current.gyro_bias.norm() <= kMaxGyroBias)) {
    return text("gyroscope bias ", current.gyro_bias.norm(), " rad/s (limit ", kMaxGyroBias, ")");
  }
  if (!(step.norm() <= kMaxStep)) {
    return text("step between two frames ", step.norm(), " m (limit ", kMaxStep, ")");
  }
  if (!(std::abs(step.z()) <= kMaxVerticalStep)) {
    return text("vertical step between two frames ", std::abs(step.z()), " m (limit ",
                kMaxVerticalStep, ")");
  }
  if (report.newest_views >= kMinJudgedPoints &&
      report.newest_inliers < kMinInlierFraction * report.newest_views) {
    return text(report.newest_inliers, " of ", report.newest_views,
                " points are where they are expected (minimum fraction ", kMinInlierFraction, ")");
  }
  return "";
}

}  // namespace slim_init::backend
