// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/host_health/innovation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>
#include <utility>

#include "pose_residual.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/text.h"
#include "track_place.h"

namespace slim_init::host_health {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kDeg = 57.29577951308232;
constexpr std::size_t kLeastTracks = 8;
constexpr std::size_t kLeastStates = 3;
// The noise of the tracks grows by no more than this factor over that of healthy frames.
constexpr double kMostGrowth = 1.5;
constexpr double kNoiseMemory = 1.0;  // [s]
// Chi-square of two degrees of freedom that one in a thousand exceeds.
constexpr double kAgrees = 13.8;
// Of the pose innovation, six degrees of freedom; three in 10^6 exceed it.
constexpr double kLargestMahalanobis = 5.8;
// Logarithm of the odds that the error of a frame that passed was real and goes on: after one of
// five standard deviations it takes 4.6 in its direction, which two in 10^6 exceed.
constexpr double kGoesOnOdds = -8.5;
// Fractions of the tracks.
constexpr double kNearlyAll = 0.7;
constexpr double kPart = 0.25;
constexpr double kHealthy = 0.8;
// Geman-McClure: a residual of this chi-square has a quarter of its weight.
constexpr double kKernel = 6.0;
constexpr int kMaxIterations = 12;
// Degrees of freedom of a track of four views in the window, and how many have to speak against the
// IMU.
constexpr int kOldDof = 5;
constexpr std::size_t kLeastOld = 2;
// A track that has moved, and is no poor one: its chi-square over the largest of one that has not.
constexpr double kMoved = 2.0;
constexpr double kLeastInverseDepth = 1e-6;  // [1/m]
// Pose of the newest frame and of the last optimized one against places that share errors; these
// come from two poses of the window, and grow with the step beyond it.
constexpr double kBothPoses = 4.0;
constexpr double kSharedErrors = 2.0;
constexpr double kLeastReach = 1e-3;  // [m]
// Pose of the newest optimized frame against the places, besides the noise of the tracks.
constexpr double kFrameTheta = 5e-4;     // [rad]
constexpr double kFramePosition = 1e-3;  // [m]
// Scale error and time offset of the gyroscope, of the angle that the body has turned by.
constexpr double kGyroScale = 0.01;
// An extrinsic rotation that is off adds to each turn, of the angle of the turn: about 2 deg.
constexpr double kRigError = 0.03;
// A pose of which the tracks say nothing.
constexpr double kWeakTheta = 1.0;      // [rad]
constexpr double kWeakPosition = 10.0;  // [m]
// Damage that begins within an interval changes the velocity more than damage of the same effect
// on the position over all of it; root mean square over onsets in its first four fifths.
constexpr double kOnset = 2.2;
// Velocities of a healthy host and of two poses differ by no more [m/s].
constexpr double kSameVelocity = 0.4;
// For so long the IMU alone may carry a host because all of the image moves, and a part of it may
// be what is wrong with an independent window [s].
constexpr double kLongestBlind = 5.0;
// So long after it the tracks decide: the IMU alone has propagated the poses of the window [s]. And
// so long after most of the view has been replaced they do not.
constexpr double kTrusted = 1.0;
// Fewer of the tracks of a frame are left in the next one: something has come before the scene. A
// tracker loses as many as 0.42 of them in a dark hall.
constexpr double kLeastLeft = 0.4;

// Errors [theta, p] in the world that lead from `from` to `to`.
Vector6d difference(const NavState& to, const NavState& from) {
  Vector6d d;
  d << logOf(to.R_w_b * from.R_w_b.transpose()), to.p_w_b - from.p_w_b;
  return d;
}

double mahalanobis(const Vector6d& d, const Matrix6d& covariance) {
  return std::sqrt(std::max(0.0, d.dot(covariance.ldlt().solve(d))));
}

std::string rounded(double value) { return roundedText(3, value); }

// The tracks of the newest frame that have a place.
struct Scene {
  std::vector<PoseTrack> tracks;
  // The first of these fix the poses and are counted: old ones, or all if there are few of those.
  // What has just appeared may be new all over the image and agree with itself.
  std::size_t deciding = 0;
  std::size_t old = 0;  // of the tracks
  // The window's poses, which are from before the newest interval, leave them no place.
  std::vector<FeatureId> placeless;
  std::size_t moved = 0;  // of these: by far
  double sigma = 0.0;     // of a bearing, as these tracks have it [rad]
};

// The tracks' own noise: what the places of the best quarter do not explain. Of a view that moves
// the best quarter moves as well: no more than `most`.
double noiseFactor(const std::vector<PoseTrack>& tracks, double most) {
  std::vector<double> ratios;
  for (const PoseTrack& track : tracks) {
    if (track.place.dof >= 3) ratios.push_back(track.place.chi_square / track.place.dof);
  }
  if (ratios.size() < kLeastTracks) return 1.0;
  const auto quarter = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 4);
  std::nth_element(ratios.begin(), quarter, ratios.end());
  // Of chi-squares over their 3 to 17 degrees of freedom the lower quartile is 0.4 to 0.75.
  return std::clamp(std::sqrt(*quarter / 0.6), 1.0, most);
}

// Wilson and Hilferty's quantile of one in a thousand.
double largestChiSquare(int dof) {
  const double a = 2.0 / (9.0 * dof);
  return dof * std::pow(1.0 - a + 3.09 * std::sqrt(a), 3);
}

Scene sceneOf(const std::vector<NavState>& optimized, const FrameObservation& newest,
              const InnovationInput& input, double most_noise) {
  const double sigma = input.calibration.sigmaBearing();
  Scene scene;
  std::vector<CameraPose> cameras(optimized.size());
  std::unordered_map<FeatureId, std::size_t> index;
  for (std::size_t k = 0; k < newest.points.size(); ++k) index[newest.points[k].id] = k;
  std::vector<std::vector<TrackView>> views(newest.points.size());
  for (std::vector<TrackView>& of_track : views) of_track.reserve(optimized.size());
  for (std::size_t i = 0; i < optimized.size(); ++i) {
    cameras[i] = cameraOf(optimized[i], input.calibration);
    const FrameObservation* frame = frameAt(input.frames, optimized[i].t);
    if (frame == nullptr) continue;
    for (const PointObservation& point : frame->points) {
      const auto found = index.find(point.id);
      if (found == index.end()) continue;
      views[found->second].push_back({&cameras[i], point.bearing.normalized()});
    }
  }
  for (std::size_t k = 0; k < views.size(); ++k) {
    if (views[k].size() < 2) continue;
    PoseTrack track;
    track.id = newest.points[k].id;
    track.bearing = newest.points[k].bearing.normalized();
    if (!track.bearing.allFinite()) continue;
    track.basis = tangentOf(track.bearing);
    if (findPlace(views[k], sigma, kFramePosition, &track.place)) {
      scene.tracks.push_back(track);
    } else {
      scene.placeless.push_back(track.id);
    }
  }
  const double factor = noiseFactor(scene.tracks, most_noise);
  scene.sigma = factor * sigma;
  const auto ratio = [factor](const PoseTrack& track) {
    return track.place.chi_square / (factor * factor * largestChiSquare(track.place.dof));
  };
  const auto placed =
      std::partition(scene.tracks.begin(), scene.tracks.end(),
                     [&ratio](const PoseTrack& track) { return ratio(track) <= 1.0; });
  scene.moved = scene.placeless.size();
  for (auto track = placed; track != scene.tracks.end(); ++track) {
    scene.placeless.push_back(track->id);
    scene.moved += ratio(*track) > kMoved ? 1 : 0;
  }
  scene.tracks.erase(placed, scene.tracks.end());
  for (PoseTrack& track : scene.tracks) track.place.covariance *= factor * factor;
  const auto young =
      std::stable_partition(scene.tracks.begin(), scene.tracks.end(),
                            [](const PoseTrack& track) { return track.place.dof >= kOldDof; });
  scene.deciding = static_cast<std::size_t>(young - scene.tracks.begin());
  scene.old = scene.deciding;
  if (scene.deciding < kLeastTracks) scene.deciding = scene.tracks.size();
  return scene;
}

// Whether so many of the tracks move that they are more than a few poor ones.
bool move(std::size_t others, std::size_t all) {
  return others >= kLeastTracks &&
         static_cast<double>(others) > (1.0 - kHealthy) * static_cast<double>(all);
}

// Whether most of the placeless tracks of `scene` have their place in `before`, the same without
// the last of the poses: what has stood until then does not move all at once, so that this pose is
// the one that is wrong.
bool isOfLastPose(const Scene& scene, const Scene& before) {
  const std::set<FeatureId> placeless(scene.placeless.begin(), scene.placeless.end());
  const auto regained =
      std::count_if(before.tracks.begin(), before.tracks.end(),
                    [&placeless](const PoseTrack& track) { return placeless.count(track.id) > 0; });
  return 2 * static_cast<std::size_t>(regained) > placeless.size();
}

// A pose from the tracks, and which of them agree with it.
struct PoseFit {
  NavState pose;
  Matrix6d covariance = Matrix6d::Zero();  // of the tracks alone
  std::vector<char> agrees;
  std::size_t count = 0;  // of them
  double fraction = 0.0;  // of the deciding tracks
  double cost = 0.0;      // their chi-squares, each truncated
};

// An inverse depth with an error of its own size would draw the pose towards the last one: the
// noise of the place is in residual and Jacobian alike. That of all views, the newest included,
// does not.
void useBothDepths(const PoseTrack& track, PoseResidual* residual) {
  const double before = track.place.inverse_depth;
  if (std::abs(before) < kLeastInverseDepth) return;
  residual->J.rightCols<3>() *= residual->inverse_depth / before;
}

class PoseSolver {
 public:
  PoseSolver(const Scene& scene, const Calibration& calibration)
      : scene_(scene), calibration_(calibration) {}

  // From `start`, with a kernel that begins at the median residual there or at one. `prior`: the
  // covariance of the start; null: none.
  PoseFit fit(const NavState& start, bool wide, const Matrix6d* prior) const {
    NavState pose = start;
    const Matrix6d prior_information =
        prior == nullptr ? Matrix6d::Zero() : Matrix6d(prior->inverse());
    double scale = wide ? widestKernel(pose) : 1.0;
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      Matrix6d H = weak() + prior_information;
      Vector6d g = prior_information * difference(pose, start);
      accumulate(pose, scale, &H, &g);
      const Vector6d step = -H.ldlt().solve(g);
      pose.R_w_b = expOf(step.head<3>()) * pose.R_w_b;
      pose.p_w_b += step.tail<3>();
      const bool last_scale = scale <= 1.0;
      scale = std::max(1.0, scale / 3.0);
      if (last_scale && step.head<3>().norm() < 1e-5 && step.tail<3>().norm() < 1e-4) break;
    }
    return finish(pose, prior_information);
  }

 private:
  static Matrix6d weak() {
    Vector6d information;
    information << Eigen::Vector3d::Constant(1.0 / (kWeakTheta * kWeakTheta)),
        Eigen::Vector3d::Constant(1.0 / (kWeakPosition * kWeakPosition));
    return information.asDiagonal();
  }

  double widestKernel(const NavState& pose) const {
    const CameraPose camera = cameraOf(pose, calibration_);
    std::vector<double> squares;
    PoseResidual residual;
    for (std::size_t i = 0; i < scene_.deciding; ++i) {
      if (!poseResidual(scene_.tracks[i], camera, scene_.sigma, &residual)) continue;
      squares.push_back(residual.r.dot(residual.information * residual.r));
    }
    return squares.empty() ? 1.0 : std::max(1.0, std::sqrt(middle(std::move(squares)) / kKernel));
  }

  void accumulate(const NavState& pose, double scale, Matrix6d* H, Vector6d* g) const {
    const CameraPose camera = cameraOf(pose, calibration_);
    const double kernel = scale * scale * kKernel;
    PoseResidual residual;
    for (std::size_t i = 0; i < scene_.deciding; ++i) {
      const PoseTrack& track = scene_.tracks[i];
      if (!poseResidual(track, camera, scene_.sigma, &residual)) continue;
      const Eigen::Vector2d weighted = residual.information * residual.r;
      const double root = 1.0 / (1.0 + residual.r.dot(weighted) / kernel);
      useBothDepths(track, &residual);
      const Eigen::Matrix<double, 2, 6> WJ = residual.information * residual.J;
      H->noalias() += root * root * residual.J.transpose() * WJ;
      g->noalias() += root * root * residual.J.transpose() * weighted;
    }
  }

  PoseFit finish(const NavState& pose, const Matrix6d& prior_information) const {
    PoseFit fit;
    fit.pose = pose;
    const CameraPose camera = cameraOf(pose, calibration_);
    Matrix6d H = weak();
    Matrix6d of_pose = Matrix6d::Zero();  // the deciding tracks are in the pose themselves
    PoseResidual residual;
    for (std::size_t i = 0; i < scene_.tracks.size(); ++i) {
      const bool decides = i < scene_.deciding;
      if (i == scene_.deciding) of_pose = (H + prior_information).inverse();
      double square = kAgrees;
      if (poseResidual(scene_.tracks[i], camera, scene_.sigma, &residual)) {
        if (!decides) widen(of_pose, &residual);
        square = residual.r.dot(residual.information * residual.r);
      }
      const bool agrees = square < kAgrees;
      fit.agrees.push_back(agrees ? 1 : 0);
      fit.count += agrees ? 1 : 0;
      if (!decides) continue;
      fit.cost += std::min(square, kAgrees);
      if (!agrees) continue;
      useBothDepths(scene_.tracks[i], &residual);
      H.noalias() += residual.J.transpose() * residual.information * residual.J;
    }
    const auto deciding = fit.agrees.begin() + static_cast<std::ptrdiff_t>(scene_.deciding);
    fit.fraction = static_cast<double>(std::count(fit.agrees.begin(), deciding, 1)) /
                   static_cast<double>(scene_.deciding);
    fit.covariance = H.inverse();
    return fit;
  }

  static void widen(const Matrix6d& of_pose, PoseResidual* residual) {
    const Eigen::Matrix2d S = residual->information.inverse();
    residual->information = (S + residual->J * of_pose * residual->J.transpose()).inverse();
  }

  const Scene& scene_;
  const Calibration& calibration_;
};

// The prediction with the covariance of its pose.
struct Prediction {
  NavState state;
  Matrix6d covariance;
};

// The direction of gravity is not exact in the host's world, but the attitude of its last state is:
// the tilt of healthyCovariance() moves the prediction and does not turn it.
Prediction predictionOf(const PropagatedState& propagated, const NavState& last) {
  Prediction prediction;
  prediction.state = propagated.state;
  const Eigen::Vector3d tilt = healthyCovariance().diagonal().head<3>();
  const Eigen::Vector3d theta = propagated.covariance.diagonal().head<3>();
  const double turned = logOf(last.R_w_b.transpose() * propagated.state.R_w_b).norm();
  prediction.covariance.setZero();
  prediction.covariance.diagonal().head<3>() = (theta - tilt).cwiseMax(0.0).array() +
                                               kFrameTheta * kFrameTheta +
                                               std::pow(kGyroScale * turned, 2);
  prediction.covariance.bottomRightCorner<3, 3>() = propagated.covariance.block<3, 3>(6, 6);
  prediction.covariance.diagonal().tail<3>().array() += kFramePosition * kFramePosition;
  return prediction;
}

// The motion of before goes on.
NavState constantMotion(const std::vector<NavState>& optimized, double t) {
  const NavState& last = optimized.back();
  const NavState& before = optimized[optimized.size() - 2];
  const double share = (t - last.t) / (last.t - before.t);
  NavState state = last;
  state.R_w_b = expOf(share * logOf(last.R_w_b * before.R_w_b.transpose())) * last.R_w_b;
  state.p_w_b += share * (last.p_w_b - before.p_w_b);
  return state;
}

// Both sides of the test.
struct Fits {
  PoseFit imu;           // the pose that the IMU allows
  PoseFit images;        // the pose that most tracks want
  bool allowed = false;  // the IMU allows its pose indeed: a robust fit may leave it
};

// Covariance of an innovation, but for that of the prediction. `pose` has `covariance` from tracks.
Matrix6d ofImages(const NavState& pose, const Matrix6d& covariance,
                  const std::vector<NavState>& optimized) {
  const NavState& last = optimized.back();
  double reach = kLeastReach;
  for (const NavState& state : optimized) {
    reach = std::max(reach, (state.p_w_b - last.p_w_b).norm());
  }
  const double step = (pose.p_w_b - last.p_w_b).norm() / reach;
  return (kBothPoses + kSharedErrors * step * step) * covariance;
}

Fits fitBoth(const PoseSolver& solver, const Prediction& prediction,
             const std::vector<NavState>& optimized) {
  Fits fits;
  fits.imu = solver.fit(prediction.state, false, &prediction.covariance);
  fits.images = solver.fit(fits.imu.pose, false, nullptr);
  if (fits.imu.fraction < kHealthy) {
    // Without the tracks of both the search ends where it begins.
    for (const NavState& start :
         {prediction.state, optimized.back(), constantMotion(optimized, prediction.state.t)}) {
      PoseFit other = solver.fit(start, true, nullptr);
      if (other.cost < fits.images.cost) fits.images = std::move(other);
    }
  }
  // Where the tracks do not fix a pose, without parallax, the search may lose them.
  if (!(fits.images.cost < fits.imu.cost + kAgrees)) fits.images = fits.imu;
  const Matrix6d expected =
      prediction.covariance + ofImages(fits.imu.pose, fits.imu.covariance, optimized);
  fits.allowed =
      mahalanobis(difference(fits.imu.pose, prediction.state), expected) < kLargestMahalanobis;
  return fits;
}

// Keeps out what does not agree with `world`, everything if it is null, and the placeless tracks.
// `decide`: TrackTrust.
void setMoving(const PoseFit* world, const Scene& scene, bool decide, Innovation* result) {
  if (!decide) result->moving = scene.placeless;
  for (std::size_t i = 0; i < scene.tracks.size(); ++i) {
    if (world == nullptr || !world->agrees[i]) result->moving.push_back(scene.tracks[i].id);
  }
  std::sort(result->moving.begin(), result->moving.end());
  const std::size_t all = scene.tracks.size() + scene.placeless.size();
  result->blind =
      static_cast<double>(result->moving.size()) > (1.0 - kPart) * static_cast<double>(all);
}

// Placeless tracks contradict poses that are older than anything that is wrong with the newest
// interval: if they are most they cannot speak against the IMU, and neither can new ones where most
// old ones disagree.
Culprit culpritOf(const Scene& scene, const Fits& fits, double distance, bool goes_on,
                  const TrackTrust& trust) {
  const bool decide = trust.decide;
  const std::size_t placed = scene.tracks.size(), all = placed + scene.placeless.size();
  const auto moves = [&scene, placed, all, decide](const PoseFit& fit) {
    return move(placed - fit.count + (decide ? 0 : scene.moved), all);
  };
  const double b = fits.images.fraction;
  const auto old = fits.images.agrees.begin() + static_cast<std::ptrdiff_t>(scene.old);
  const auto of_old = static_cast<std::size_t>(std::count(fits.images.agrees.begin(), old, 1));
  const bool may_accuse = decide || (!trust.replaced && of_old >= kLeastOld &&
                                     2 * of_old >= scene.old && 2 * fits.images.count >= all);
  if (goes_on && may_accuse && b >= kNearlyAll) return Culprit::kImu;
  // Damage leaves no part of the tracks where the IMU is.
  if (fits.allowed && fits.imu.fraction >= kPart) {
    return moves(fits.imu) ? Culprit::kImages : Culprit::kNone;
  }
  if (distance < kLargestMahalanobis) {
    return moves(fits.images) ? Culprit::kImages : Culprit::kNone;
  }
  if (!may_accuse) return Culprit::kImages;
  return b >= kNearlyAll ? Culprit::kImu : Culprit::kUnclear;
}

// Of the pose of the images from a prediction.
struct Difference {
  Vector6d d;
  double mahalanobis = 0.0;
  // The error of constant size over the interval that has its effect on the pose.
  Vector6d error;
  bool goes_on = false;

  void writeTo(Innovation* result) const {
    result->mahalanobis = mahalanobis;
    result->rotation_deg = kDeg * d.head<3>().norm();
    result->position_m = d.tail<3>().norm();
  }
};

// Whether `d`, of covariance S, shows the error of the frame before again: the likelihood of an
// error in its direction, of about its size, over that of none (covariances S + e e^T and S).
bool goesOn(const Vector6d& d, double interval, const Matrix6d& S, const TrackTrust& trust) {
  Vector6d e;
  e << trust.error.head<3>() * interval, 0.5 * trust.error.tail<3>() * interval * interval;
  const Vector6d weighted = S.ldlt().solve(e);
  const double along = weighted.dot(d), grown = 1.0 + weighted.dot(e);
  return along > 0.0 && 0.5 * (along * along / grown - std::log(grown)) + trust.log_odds > 0.0;
}

// `pose` has `covariance` from tracks.
Difference differenceOf(const NavState& pose, const Matrix6d& covariance,
                        const Prediction& prediction, const InnovationInput& frame,
                        const TrackTrust& trust) {
  const double interval = frame.interval();
  Matrix6d expected = prediction.covariance + ofImages(pose, covariance, frame.optimized);
  Difference result;
  result.d = difference(pose, prediction.state);
  result.mahalanobis = mahalanobis(result.d, expected);
  result.error << result.d.head<3>() / interval, 2.0 * result.d.tail<3>() / (interval * interval);
  // The turn is that of the poses before: damage of the gyroscope would excuse itself.
  const NavState &last = frame.optimized.back(), &before = (&last)[-1];
  const double turned = logOf(before.R_w_b.transpose() * last.R_w_b).norm() / (last.t - before.t);
  expected.diagonal().head<3>().array() += std::pow(kRigError * turned * interval, 2);
  result.goes_on = goesOn(result.d, interval, expected, trust);
  return result;
}

// As large as that error, or as what a body may do while nothing is known.
void setSizes(Innovation* result) {
  result->gyro_sigma = kOnset * result->error.head<3>().norm();
  result->accel_sigma = kOnset * result->error.tail<3>().norm();
  if (result->culprit == Culprit::kUnclear) {
    result->accel_sigma = std::max(result->accel_sigma, kUnknownAccel);
    result->gyro_sigma = std::max(result->gyro_sigma, kUnknownGyro);
  }
}

std::string sentenceOf(const Innovation& result) {
  const auto percent = [](double fraction) {
    return std::to_string(static_cast<int>(std::lround(100.0 * fraction))) + " %";
  };
  const std::string pose = "the pose of the images is " + rounded(result.position_m) + " m and " +
                           rounded(result.rotation_deg) + " deg from the IMU's prediction, " +
                           rounded(result.mahalanobis) + " standard deviations (limit " +
                           rounded(kLargestMahalanobis) + ")";
  const std::string tracks =
      percent(result.agree_images) + " of " + std::to_string(result.deciding) +
      " known tracks agree with it (limit " + percent(kNearlyAll) + ")" +
      (result.agree_imu < kPart
           ? ", " + percent(result.agree_imu) + " with the IMU (limit " + percent(kPart) + ")"
           : "");
  switch (result.culprit) {
    case Culprit::kNone: return "images and IMU agree: " + pose;
    case Culprit::kImu:
      return std::string("the IMU data are inconsistent") +
             (result.mahalanobis < kLargestMahalanobis ? " in two frames in a row: " : ": ") +
             pose + ", and " + tracks;
    case Culprit::kImages:
      return "a part of the image moves: " + percent(result.agree_imu) + " of " +
             std::to_string(result.deciding) + " known tracks agree with the IMU, " +
             std::to_string(result.moving.size()) + " tracks move";
    case Culprit::kUnclear:
      return "images and IMU contradict each other: " + pose + ", and " + tracks;
    case Culprit::kNotJudged: break;
  }
  return std::to_string(result.tracks) + " tracks have a known place (limit " +
         std::to_string(kLeastTracks) + ")";
}

// Whether the pose of the images agrees with another prediction. If nearly all tracks agree with
// that pose and nothing was found, the other prediction decides: damage that is small against what
// is known of the host's velocity.
bool compareTo(const InnovationInput& frame, const TrackTrust& trust, Innovation* result) {
  // A part of the tracks was where the IMU is, and the pose of the images is another minimum.
  if (result->culprit == Culprit::kNone && result->mahalanobis >= kLargestMahalanobis) return true;
  const Prediction prediction = predictionOf(frame.predicted, frame.optimized.back());
  const Difference other =
      differenceOf(result->images, result->covariance, prediction, frame, trust);
  result->error = other.error;
  if (other.mahalanobis < kLargestMahalanobis && !other.goes_on) return true;
  if (result->culprit != Culprit::kNone) return false;
  result->culprit = Culprit::kImu;
  result->best = result->images;
  other.writeTo(result);
  setSizes(result);
  result->message = sentenceOf(*result);
  return false;
}

bool areFinite(const std::vector<NavState>& states) {
  return std::all_of(states.begin(), states.end(),
                     [](const NavState& state) { return state.isFinite(); });
}

}  // namespace

bool poseResidual(const PoseTrack& track, const CameraPose& camera, double sigma,
                  PoseResidual* residual) {
  PlaceResidual place;
  if (!residualOf(track.place, camera, track.bearing, track.basis, &place)) return false;
  residual->r = place.r;
  // The ray turns about the body, which carries the camera.
  const double rho = track.place.inverse_depth;
  const Eigen::Vector3d from_body = place.ray + rho * camera.arm;
  residual->J.leftCols<3>() = place.by_expected * skewOf(from_body);
  residual->J.rightCols<3>() = -rho * place.by_expected;
  const Eigen::Matrix<double, 3, 2> CJ = track.place.covariance * place.by_place.transpose();
  Eigen::Matrix2d S = place.by_place * CJ;
  S.diagonal().array() += sigma * sigma;
  residual->information = S.inverse();
  residual->inverse_depth = rho - CJ.row(2).dot(residual->information * residual->r);
  return true;
}

Innovation innovationOf(const InnovationInput& frame, const TrackTrust& trust) {
  const std::vector<NavState>& optimized = frame.optimized;
  const PropagatedState& predicted = frame.predicted;
  Innovation result;
  result.images = result.best = predicted.state;
  const FrameObservation* newest = frameAt(frame.frames, predicted.state.t);
  if (optimized.size() < kLeastStates || newest == nullptr || !areFinite(optimized) ||
      !predicted.state.isFinite() || !predicted.covariance.allFinite() ||
      !(frame.interval() > 0.0)) {
    result.message = "the window, the prediction or the newest frame is missing or not finite";
    return result;
  }
  Scene scene = sceneOf(optimized, *newest, frame, trust.most_noise);
  if (trust.agreed && move(scene.moved, scene.tracks.size() + scene.placeless.size())) {
    Scene before =
        sceneOf({optimized.begin(), optimized.end() - 1}, *newest, frame, trust.most_noise);
    if (isOfLastPose(scene, before)) scene = std::move(before);
  }
  result.noise = scene.sigma * frame.calibration.focal_px / frame.calibration.pointSigmaPx();
  result.tracks = static_cast<int>(scene.tracks.size());
  result.deciding = static_cast<int>(scene.deciding);
  if (scene.tracks.size() < kLeastTracks) {
    if (!trust.decide && move(scene.moved, scene.tracks.size() + scene.placeless.size())) {
      result.culprit = Culprit::kImages;
      setMoving(nullptr, scene, false, &result);
    }
    result.message = sentenceOf(result);
    return result;
  }
  const Prediction prediction = predictionOf(predicted, optimized.back());
  const Fits fits = fitBoth(PoseSolver(scene, frame.calibration), prediction, optimized);
  result.agree_imu = fits.allowed ? fits.imu.fraction : 0.0;
  result.agree_images = fits.images.fraction;
  result.covariance = fits.images.covariance;
  const Difference found =
      differenceOf(fits.images.pose, result.covariance, prediction, frame, trust);
  found.writeTo(&result);
  result.error = found.error;
  result.culprit = culpritOf(scene, fits, found.mahalanobis, found.goes_on, trust);
  const auto stateOf = [&](NavState pose) {
    pose.v_w_b += (pose.p_w_b - prediction.state.p_w_b) / frame.interval();
    return pose;
  };
  result.images = stateOf(fits.images.pose);
  if (fits.allowed) result.best = stateOf(fits.imu.pose);
  if (result.culprit == Culprit::kImu) result.best = result.images;
  if (result.culprit == Culprit::kImages) {
    const PoseFit* world = result.mahalanobis < kLargestMahalanobis ? &fits.images : nullptr;
    if (fits.allowed && fits.imu.fraction >= kPart) world = &fits.imu;
    setMoving(world, scene, trust.decide, &result);
  }
  if (result.accusesImu()) {
    setSizes(&result);
    result.damaged_since = optimized.back().t;
  }
  result.message = sentenceOf(result);
  return result;
}

// That of the last two poses, if the IMU data between them are clean.
bool InnovationMonitor::velocityOfPoses(const std::vector<NavState>& optimized,
                                        Eigen::Vector3d* velocity) const {
  if (optimized.size() < kLeastStates || std::isnan(before_.first) ||
      std::abs(optimized.back().t - before_.last) > kSameTime) {
    return false;
  }
  Eigen::Vector3d start = before_.start;
  for (const NavState& state : optimized) {
    if (std::abs(state.t - before_.first) < kSameTime) start = state.p_w_b;
  }
  *velocity = (optimized.back().p_w_b - start - before_.position) / (before_.last - before_.first) +
              before_.velocity;
  return velocity->allFinite();
}

PropagatedState InnovationMonitor::withVelocity(const Eigen::Vector3d& velocity,
                                                const InnovationInput& frame) const {
  const double interval = frame.interval();
  const Eigen::Vector3d change = velocity - frame.optimized.back().v_w_b;
  const double share = interval / (before_.last - before_.first);
  PropagatedState result = frame.predicted;
  result.state.v_w_b += change;
  result.state.p_w_b += change * interval;
  // Errors e of the two poses move the prediction by e_1 + share (e_1 - e_0), and the velocity of
  // healthyCovariance() is not used.
  const double of_pose =
      std::pow((1.0 + share) * kFramePosition, 2) + std::pow(share, 2) * before_.variance;
  const double of_velocity = healthyCovariance()(3, 3) * interval * interval;
  Eigen::Matrix3d position = result.covariance.block<3, 3>(6, 6);
  position.diagonal().array() -= of_velocity;
  position.diagonal() = position.diagonal().cwiseMax(0.0);
  position.diagonal().array() += of_pose;
  result.covariance.block<3, 3>(6, 6) = position;
  return result;
}

void InnovationMonitor::keep(const InnovationInput& frame, const Innovation& result) {
  const NavState &last = frame.optimized.back(), &predicted = frame.predicted.state;
  before_.first = last.t;
  before_.last = predicted.t;
  before_.start = last.p_w_b;
  before_.position = predicted.p_w_b - last.p_w_b - last.v_w_b * frame.interval();
  before_.velocity = predicted.v_w_b - last.v_w_b;
  before_.variance =
      ofImages(result.images, result.covariance, frame.optimized).diagonal().tail<3>().maxCoeff();
}

Innovation InnovationMonitor::judge(const InnovationInput& frame, bool uncertain) {
  const double t = frame.predicted.state.t;
  if (blindEnds(frame)) trusted_since_ = t;
  TrackTrust trust;
  // A host whose poses have not agreed with its tracks yet has them wrong.
  trust.decide = uncertain || std::isnan(noise_) || t - trusted_since_ < kTrusted;
  if (!std::isnan(noise_)) trust.most_noise = std::min(kMostNoise, kMostGrowth * noise_);
  trust.agreed = agreed_;
  if (isReplaced(frame)) replaced_ = t;
  trust.replaced = t - replaced_ < kTrusted;
  trust.error = error_;
  trust.log_odds = damaged_ ? 0.0 : kGoesOnOdds;
  Innovation result = judgeFrame(frame, trust);
  if (result.culprit != Culprit::kNotJudged) {
    judged_ = t;
    if (!damaged_) damaged_since_ = result.damaged_since;
  } else if (damaged_ && !frame.optimized.empty() &&
             t - judged_ < judged_ - damaged_since_ + kSameTime) {
    result.goes_on = suspicious_ = true;
    result.error = error_;
    setSizes(&result);
    result.damaged_since = frame.optimized.back().t;
    result.message += ", and the IMU data of the frame before are inconsistent";
  }
  damaged_ = result.accusesImu();
  // Damage spoils the poses of its frames, which then take the places of all tracks.
  agreed_ = (damaged_ ? result.agree_images : result.agree_imu) >= kNearlyAll;
  if (result.culprit == Culprit::kImages) {
    if (!(t - moved_ < kLongestBlind)) moves_since_ = t;
    moved_ = t;
  }
  // What moves in the images goes on as well.
  const bool of_imu = (damaged_ || result.culprit == Culprit::kNone) && !(t - moved_ < kTrusted);
  error_ = of_imu ? result.error : Vector6d::Zero();
  if (result.culprit == Culprit::kNone) {
    const double weight = frame.interval() / (kNoiseMemory + frame.interval());
    noise_ = std::isnan(noise_) ? result.noise : noise_ + weight * (result.noise - noise_);
    blind_since_ = kNotComputed;
  }
  moving_.clear();
  if (!result.blind) return result;
  moving_.insert(result.moving.begin(), result.moving.end());
  if (std::isnan(blind_since_)) blind_since_ = t;
  if (t - blind_since_ <= kLongestBlind) return result;
  // It may be the IMU, or the poses that the host had before.
  result.culprit = Culprit::kUnclear;
  result.moving.clear();
  result.damaged_since = frame.optimized.back().t;
  result.error.setZero();
  setSizes(&result);
  return result;
}

// What has filled the view is gone at once.
bool InnovationMonitor::blindEnds(const InnovationInput& frame) const {
  const FrameObservation* newest = frameAt(frame.frames, frame.predicted.state.t);
  if (newest == nullptr || moving_.empty()) return false;
  const auto still =
      std::count_if(newest->points.begin(), newest->points.end(),
                    [this](const PointObservation& point) { return moving_.count(point.id) > 0; });
  return static_cast<double>(still) < kPart * static_cast<double>(moving_.size());
}

bool InnovationMonitor::isReplaced(const InnovationInput& frame) const {
  if (frame.optimized.empty()) return false;
  const FrameObservation* before = frameAt(frame.frames, frame.optimized.back().t);
  const FrameObservation* newest = frameAt(frame.frames, frame.predicted.state.t);
  if (before == nullptr || newest == nullptr) return false;
  std::set<FeatureId> ids;
  for (const PointObservation& point : newest->points) ids.insert(point.id);
  const auto left =
      std::count_if(before->points.begin(), before->points.end(),
                    [&ids](const PointObservation& point) { return ids.count(point.id) > 0; });
  return static_cast<double>(left) < kLeastLeft * static_cast<double>(before->points.size());
}

Innovation InnovationMonitor::judgeFrame(const InnovationInput& frame, const TrackTrust& trust) {
  Eigen::Vector3d velocity;
  if (!velocityOfPoses(frame.optimized, &velocity)) {
    Innovation result = innovationOf(frame, trust);
    suspicious_ = result.accusesImu();
    if (!frame.optimized.empty()) keep(frame, result);
    return result;
  }
  const double off = (velocity - frame.optimized.back().v_w_b).norm();
  const PropagatedState by_poses = withVelocity(velocity, frame);
  const InnovationInput other = {frame.optimized, by_poses, frame.frames, frame.calibration};
  TrackTrust of_host = trust;
  of_host.error.setZero();
  Innovation result = suspicious_ ? innovationOf(other, trust) : innovationOf(frame, of_host);
  if (!suspicious_ && (result.culprit == Culprit::kNone || result.accusesImu())) {
    const bool same = compareTo(other, trust, &result);
    if (result.accusesImu() && same) {
      result.culprit = Culprit::kUnclear;
      result.message = sentenceOf(result);
      if (off > kSameVelocity) {
        result.message = "the host's velocity is " + rounded(off) +
                         " m/s from that of its last two poses: " + result.message;
      }
    }
  }
  // Too little of it may have been in the interval before to be seen there.
  if (result.accusesImu()) result.damaged_since = before_.first;
  suspicious_ = result.accusesImu() ||
                (suspicious_ && result.culprit != Culprit::kNotJudged && off > kSameVelocity);
  keep(frame, result);
  return result;
}

bool InnovationMonitor::imagesMoved(double first) const {
  return moved_ >= first && moved_ - moves_since_ <= kLongestBlind;
}

void InnovationMonitor::reset() { *this = InnovationMonitor(); }

}  // namespace slim_init::host_health
