// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/visual_inertial_problem.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimation/inertial_factor.h"
#include "geometry/dense.h"
#include "geometry/so3.h"
#include "priors/sensor_priors.h"

namespace slim_init {
namespace {

// Damping of a track's own parameters, relative to its largest information: where the views do not
// determine one of them (the distance of a far point), it stays where it is.
constexpr double kTrackDamping = 1e-7;
// A track whose own step is longer than this squared length [sigma^2] takes it before the poses
// move.
constexpr double kTrackStep = 1.0;
// Marquardt damping, relative to the diagonal of the information: at the start, and its floor after
// good steps. Refused, a step raises it from the first on at least: from the smallest one it would
// take four refusals to matter.
constexpr double kFirstDamping = 1e-6;
constexpr double kSmallestDamping = 1e-9;
// Work of a linearisation per view, per pair of views of a track (with a rolling shutter), and per
// square of the number of unknowns [units]: fitted to the times of 5 to 25 keyframes with 30 to 250
// points, 10 % off on average.
constexpr double kWorkPerView = 0.1;
constexpr double kWorkPerPairOfViews = 0.0115;
constexpr double kWorkPerRollingPair = 0.07;
constexpr double kWorkOfSolve = 2.2e-3;

double square(double x) { return x * x; }

}  // namespace

VisualInertialProblem::VisualInertialProblem(const InitWindow& window,
                                             const std::vector<Track>& lines,
                                             const std::vector<Preintegration>& pre,
                                             const RefinementOptions& options,
                                             const InertialOptions& inertial,
                                             const WindowPriors& priors)
    : window_(window),
      pre_(pre),
      options_(options),
      inertial_(inertial),
      layout_(window.size(), true),
      t_b_c_(window.calibration().t_b_c),
      readout_s_(window.calibration().readout_s),
      rolling_(readout_s_ > 0.0),
      by_row_(rolling_ || priors.rig.sigmas.readout_s > 0.0),
      priors_(priors) {
  const Eigen::Matrix3d& R_b_c = window.calibration().R_b_c;
  setPreintegrated(0.0);
  setNoise(window.calibration().sigmaBearing(), window.calibration().sigmaLine());
  if (priors_.known) {
    Eigen::MatrixXd information;
    const bool valid =
        inverseSeenBy(priors_.known->covariance, StateCovariance::Identity(), &information);
    if (valid) known_information_ = information;
    whitening_valid_ = whitening_valid_ && valid;
  }
  const auto add = [](const Track& track, const auto& viewOf, auto* tracks) {
    const int begin = static_cast<int>(tracks->views.size());
    for (int s = track.begin; s < track.end; ++s) tracks->views.push_back(viewOf(s));
    tracks->ranges.push_back({track.id, begin, begin + track.size()});
  };
  const auto pointView = [&](int s) {
    const WindowPoint& point = window.pointObservations()[s];
    const Eigen::Vector3d bearing_b = R_b_c * point.bearing;
    return PointView{point.keyframe, bearing_b, tangentBasis(bearing_b).transpose(), point.row};
  };
  const auto lineView = [&](int s) {
    const WindowLine& line = window.lineObservations()[s];
    return LineView{line.keyframe, R_b_c * line.start_bearing, R_b_c * line.end_bearing,
                    line.start_row, line.end_row};
  };
  points_.views.reserve(window.pointObservations().size());
  for (const Track& track : window.pointTracks()) add(track, pointView, &points_);
  if (!options_.use_lines) return;
  for (const Track& track : lines) {
    if (track.size() >= kMinLineViews) add(track, lineView, &lines_);
  }
}

void VisualInertialProblem::setPreintegrated(double td_shift) {
  td_shift_ = td_shift;
  whitening_.resize(pre_.size());
  whitening_valid_ = true;
  for (std::size_t i = 0; i < pre_.size(); ++i) {
    whitening_valid_ = inertialWhitening(pre_[i], &whitening_[i]) && whitening_valid_;
  }
  speeds_ = speedFactors(window_, td_shift);
  instants_ = imuInstants(window_, td_shift, pre_.front().gyro_bias, pre_.front().accel_bias);
}

void VisualInertialProblem::setNoise(double sigma_point_rad, double sigma_line_rad) {
  points_.sigma = sigma_point_rad;
  lines_.sigma = sigma_line_rad;
}

int VisualInertialProblem::visualDof() const {
  return static_cast<int>(2 * (points_.views.size() + lines_.views.size()) -
                          3 * points_.ranges.size() - 4 * lines_.ranges.size());
}

void VisualInertialProblem::triangulateAll(const WindowState& state) {
  structure_ = Structure();
  structure_.points.reserve(points_.ranges.size());
  for (const Track& t : points_.ranges) {
    structure_.points.push_back(triangulate(&points_.views[t.begin], t.size(), state, t_b_c_));
    if (pointsAtInfinity()) structure_.points.back().inverse_depth = 0.0;
  }
  for (const Track& t : lines_.ranges) {
    LineParameters line;
    triangulate(&lines_.views[t.begin], t.size(), state, t_b_c_, &line);
    structure_.lines.push_back(line);
  }
}

double VisualInertialProblem::addPriors(const WindowState& state, System* system) const {
  const auto add = [system](int at, double information, const Eigen::Vector3d& value) {
    system->H.diagonal().segment<3>(at).array() += information;
    system->g.segment<3>(at) += information * value;
    return information * value.squaredNorm();
  };
  double cost = 0.0;
  if (!priors_.known) {
    const ImuBiases prior = assumedImuBiases(priors_.biases, inertial_);
    const AccelBiasTerm accel = accelBiasTerm(priors_.biases, inertial_, state.accel_bias);
    // Windows that need a prior on the motion are too short to show a large bias.
    const bool tail = options_.estimate_accel_bias && !priors_.motion;
    const double sigma = tail ? accel.sigma : prior.accel_sigma;
    cost = add(layout_.accelBias(), options_.estimate_accel_bias ? 1.0 / square(sigma) : kHold,
               state.accel_bias - prior.accel);
    if (tail) cost = accel.cost;
    cost += add(layout_.gyroBias(), 1.0 / square(prior.gyro_sigma), state.gyro_bias - prior.gyro);
  }
  if (!priors_.motion) return cost;
  const double duration = window_.times().back() - window_.times().front();
  const double w_change = 1.0 / square(priors_.motion->acceleration_sigma * duration);
  const Eigen::Vector3d change = state.v_b0.rightCols<1>() - state.v_b0.leftCols<1>();
  const int middle = MotionPrior::middle(layout_.n);
  const int first = layout_.velocity(0), last = layout_.velocity(layout_.n - 1);
  const double of_speed = add(layout_.velocity(middle), 1.0 / square(priors_.motion->speed_sigma),
                              state.v_b0.col(middle));
  add(first, w_change, -change);
  const double of_change = add(last, w_change, change);
  system->H.block<3, 3>(last, first).diagonal().array() -= w_change;
  return cost + (of_speed + of_change);
}

double VisualInertialProblem::addKnownState(const WindowState& state, System* system) const {
  const StateResidual known =
      stateResidual(state, *priors_.known, window_.calibration(), instants_.front());
  const Eigen::MatrixXd weighted = product(known.J.transpose(), known_information_);
  const Eigen::MatrixXd JJ = product(weighted, known.J);
  const Eigen::VectorXd Jr = product(weighted, known.r);
  // The first velocity, then what follows the velocities.
  constexpr int rest = kStateColumns - 3;
  const int at_v = layout_.velocity(0), at_rest = layout_.gyroBias();
  system->g.segment<3>(at_v) += Jr.head<3>();
  system->g.segment(at_rest, rest) += Jr.segment(3, rest);
  system->H.block<3, 3>(at_v, at_v) += JJ.topLeftCorner<3, 3>();
  system->H.block(at_rest, at_v, rest, 3) += JJ.block(3, 0, rest, 3);
  system->H.block(at_rest, at_rest, rest, rest) += JJ.block(3, 3, rest, rest);
  return known.r.dot(known_information_ * known.r);
}

std::vector<SpeedResidual> VisualInertialProblem::speedResiduals(const WindowState& state) const {
  std::vector<SpeedResidual> residuals;
  residuals.reserve(speeds_.size());
  for (const SpeedFactor& speed : speeds_) {
    const Eigen::Vector3d rate =
        instants_[speed.keyframe].rate + pre_.front().gyro_bias - state.gyro_bias;
    residuals.push_back(speedResidual(state, speed, window_.calibration(), rate));
  }
  return residuals;
}

SpeedUse VisualInertialProblem::speedUse() const {
  if (speeds_.empty()) return {};
  return fitSpeeds(speedResiduals(final_state_), window_.calibration().speed_sensor.scale_sigma)
      .use;
}

// The common error of the speeds is eliminated: of the normal equations it leaves a product over
// all velocities, like a track over its poses.
double VisualInertialProblem::addSpeeds(const WindowState& state, System* system) const {
  if (speeds_.empty()) return 0.0;
  const std::vector<SpeedResidual> residuals = speedResiduals(state);
  const double scale_sigma = window_.calibration().speed_sensor.scale_sigma;
  const SpeedFit fit = fitSpeeds(residuals, scale_sigma);
  double information = fit.scale_weight / square(scale_sigma),
         gradient = fit.use.scale_error * information;
  Eigen::VectorXd with_scale = Eigen::VectorXd::Zero(layout_.size());
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const SpeedResidual& one = residuals[i];
    const Eigen::Vector3d r = one.r + fit.use.scale_error * one.by_scale;
    const Eigen::Matrix<double, 3, kSpeedColumns> J = (1.0 + fit.use.scale_error) * one.J;
    const Eigen::Matrix<double, 3, kSpeedColumns> weighted = fit.weights[i] * J;
    information += fit.weights[i] * one.by_scale.squaredNorm();
    gradient += fit.weights[i] * one.by_scale.dot(r);
    // Ascending, so that the blocks are in the lower triangle.
    const int k = speeds_[i].keyframe;
    const int at[] = {layout_.pose(k), layout_.velocity(k), layout_.gyroBias(), layout_.rig()};
    for (int a = 0; a < 4; ++a) {
      const Eigen::Matrix3d J_a = weighted.middleCols<3>(3 * a);
      system->g.segment<3>(at[a]) += J_a.transpose() * r;
      with_scale.segment<3>(at[a]) += J_a.transpose() * one.by_scale;
      for (int b = 0; b <= a; ++b) {
        system->H.block<3, 3>(at[a], at[b]) += J_a.transpose() * J.middleCols<3>(3 * b);
      }
    }
  }
  system->H.selfadjointView<Eigen::Lower>().rankUpdate(with_scale, -1.0 / information);
  system->g -= (gradient / information) * with_scale;
  return fit.cost;
}

double VisualInertialProblem::addInertialFactor(
    int i, const Eigen::Matrix<double, 9, 1>& residual,
    const Eigen::Matrix<double, 9, kRigInertialColumns>& jacobian, System* system) const {
  // Lazy products: for these sizes Eigen would call its kernel for large matrices.
  constexpr int kColumns = kRigInertialColumns;
  const Eigen::Matrix<double, kColumns, 9> J =
      jacobian.transpose().lazyProduct(whitening_[i].transpose());
  const Eigen::Matrix<double, 9, 1> r = whitening_[i] * residual;
  // Of the rotation alone: the whitening is lower triangular.
  system->rotation_cost += r.head<3>().squaredNorm();
  const Eigen::Matrix<double, kColumns, 1> Jr = J * r;
  // Local columns in contiguous groups of the error vector.
  struct Group {
    int from, size, to;
  };
  const Group groups[] = {{0, 12, layout_.pose(i)},
                          {12, 6, layout_.velocity(i)},
                          {18, kColumns - 18, layout_.gyroBias()}};
  for (const Group& a : groups) {
    system->g.segment(a.to, a.size) += Jr.segment(a.from, a.size);
    for (const Group& b : groups) {
      if (b.to > a.to) continue;
      system->H.block(a.to, b.to, a.size, b.size) +=
          J.middleRows(a.from, a.size).lazyProduct(J.middleRows(b.from, b.size).transpose());
    }
  }
  return r.squaredNorm();
}

double VisualInertialProblem::addInertial(const WindowState& state, System* system) {
  nominal_ = state;
  chain_.resize(layout_.n);
  const BodyOffset offset(state.rig, window_.calibration());
  for (int k = 0; k < layout_.n; ++k) {
    bodyAtNominalTime(state, k, offset, {state.rig.dtd - td_shift_, instants_[k]}, &nominal_,
                      &chain_[k]);
  }
  double cost = 0.0;
  system->rotation_cost = 0.0;
  for (int i = 0; i + 1 < layout_.n; ++i) {
    const InertialResidual factor = inertialResidual(nominal_, i, pre_[i]);
    cost += addInertialFactor(i, factor.r, chainRig(factor.J, chain_[i], chain_[i + 1]), system);
  }
  return cost;
}

template <typename View, typename Parameters, int D>
void VisualInertialProblem::evaluateView(const View& view, const Parameters& parameters,
                                         const WindowState& state, double sqrt_information,
                                         ViewDerivatives<D>* out, RowJacobian* by_row) const {
  if (by_row_) {
    const RowExposure at = {state, t_b_c_, readout_s_, instants_[view.keyframe]};
    evaluateAtRow(view, parameters, at, sqrt_information, out, by_row);
  } else {
    evaluate(view, parameters, state, t_b_c_, sqrt_information, out);
  }
}

// The readout is one column, so that its products need a sum over the views alone; the velocities
// couple every two of them.
template <int D, typename View>
void VisualInertialProblem::eliminateRows(const Track& track, const std::vector<View>& views,
                                          const Eigen::Matrix<double, D, 1>& y,
                                          const Elimination<D>& elimination, System* system) {
  Eigen::Matrix<double, 1, D> readout = Eigen::Matrix<double, 1, D>::Zero();
  for (int a = track.begin; a < track.end; ++a) {
    readout += elimination.rows[a].col(3).transpose() * elimination.K[a];
  }
  double readout_gradient = -readout * y, readout_information = -readout.squaredNorm();
  for (int a = track.begin; a < track.end; ++a) {
    const Eigen::Matrix<double, 6, 2>& J = elimination.J[a];
    const Eigen::Matrix<double, 2, D>& K = elimination.K[a];
    const auto by_velocity = elimination.rows[a].template leftCols<3>();
    const Eigen::Vector2d by_readout = elimination.rows[a].col(3);
    const Eigen::Vector2d& r = track_residuals_[a - track.begin];
    const int k = views[a].keyframe;
    readout_gradient += by_readout.dot(r);
    readout_information += by_readout.squaredNorm();
    const Eigen::RowVector2d from_readout = by_readout.transpose() - readout * K.transpose();
    system->H.block<1, 6>(layout_.readout(), layout_.pose(k)).noalias() +=
        from_readout * J.transpose();
    // Without exposures of their own the rows do not depend on the velocity.
    if (!rolling_) continue;
    system->H.block<1, 3>(layout_.readout(), layout_.velocity(k)) += from_readout * by_velocity;
    system->g.segment<3>(layout_.velocity(k)) += by_velocity.transpose() * (r - K * y);
    RowBlocks* blocks = &row_blocks_[k * layout_.n];
    for (int b = track.begin; b <= a; ++b) {
      Eigen::Matrix2d S = -K * elimination.K[b].transpose();
      if (b == a) S += Eigen::Matrix2d::Identity();
      RowBlocks& block = blocks[views[b].keyframe];
      const Eigen::Matrix<double, 3, 2> left = by_velocity.transpose() * S;
      block.pose.noalias() += left * elimination.J[b].transpose();
      block.velocity.noalias() += left * elimination.rows[b].template leftCols<3>();
      if (b == a) continue;
      const Eigen::Matrix<double, 3, 2> other =
          elimination.rows[b].template leftCols<3>().transpose() * S.transpose();
      block.other_pose.noalias() += other * J.transpose();
    }
  }
  system->g[layout_.readout()] += readout_gradient;
  system->H(layout_.readout(), layout_.readout()) += readout_information;
}

void VisualInertialProblem::addRowBlocks(System* system) const {
  const int n = layout_.n;
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b <= a; ++b) {
      const RowBlocks& block = row_blocks_[a * n + b];
      system->H.block<3, 6>(layout_.velocity(a), layout_.pose(b)) += block.pose;
      system->H.block<3, 3>(layout_.velocity(a), layout_.velocity(b)) += block.velocity;
      if (a == b) continue;
      system->H.block<3, 6>(layout_.velocity(b), layout_.pose(a)) += block.other_pose;
    }
  }
}

template <int D, typename View, typename Parameters>
double VisualInertialProblem::evaluateTrack(const Tracks<View>& tracks, std::size_t t,
                                            const Parameters& parameters, const WindowState& state,
                                            Elimination<D>* elimination) {
  const Track& range = tracks.ranges[t];
  const double c2 = square(options_.cauchy_sigmas), sqrt_information = 1.0 / tracks.sigma;
  double cost = 0.0;
  for (int a = range.begin; a < range.end; ++a) {
    ViewDerivatives<D> view;
    RowJacobian by_row;
    evaluateView(tracks.views[a], parameters, state, sqrt_information, &view, &by_row);
    const double excess = 1.0 + view.r.squaredNorm() / c2;
    cost += std::log(excess);
    const double weight = std::sqrt(1.0 / excess);
    elimination->J[a] = weight * view.J_pose.transpose();
    elimination->K[a] = weight * view.J_track;
    track_residuals_[a - range.begin] = weight * view.r;
    if (by_row_) elimination->rows[a] = weight * by_row;
  }
  factorTrack(range, t, elimination);
  return c2 * cost;
}

// A track far from its own minimum takes a step to it first, at the poses as they are (Jeong et
// al., "Pushing the envelope of modern methods for bundle adjustment", CVPR 2010): damping reaches
// the poses only.
template <int D, typename View, typename Parameters>
double VisualInertialProblem::addTracks(const Tracks<View>& tracks, const WindowState& state,
                                        std::vector<Parameters>* parameters,
                                        Elimination<D>* elimination, System* system) {
  elimination->L_inverse.resize(tracks.ranges.size());
  elimination->y.resize(tracks.ranges.size());
  elimination->J.resize(tracks.views.size());
  elimination->K.resize(tracks.views.size());
  elimination->rows.resize(by_row_ ? tracks.views.size() : 0);
  track_residuals_.resize(layout_.n);
  double cost = 0.0;
  for (std::size_t t = 0; t < tracks.ranges.size(); ++t) {
    Parameters& track = (*parameters)[t];
    double of_track = evaluateTrack(tracks, t, track, state, elimination);
    const Eigen::Matrix<double, D, 1>& y = elimination->y[t];
    if (y.squaredNorm() > kTrackStep) {
      const Parameters before = track;
      track = before.moved(-(elimination->L_inverse[t].transpose() * y));
      const double moved = evaluateTrack(tracks, t, track, state, elimination);
      if (moved < of_track) {
        of_track = moved;
      } else {
        track = before;
        evaluateTrack(tracks, t, track, state, elimination);
      }
    }
    cost += of_track;
    addToPoses(tracks.ranges[t], tracks.views, y, *elimination, system);
    if (by_row_) eliminateRows(tracks.ranges[t], tracks.views, y, *elimination, system);
  }
  return cost;
}

template <int D>
void VisualInertialProblem::factorTrack(const Track& range, std::size_t t,
                                        Elimination<D>* elimination) const {
  using MatrixD = Eigen::Matrix<double, D, D>;
  using VectorD = Eigen::Matrix<double, D, 1>;
  MatrixD information = MatrixD::Zero();
  VectorD gradient = VectorD::Zero();
  for (int a = range.begin; a < range.end; ++a) {
    const Eigen::Matrix<double, 2, D>& J_track = elimination->K[a];
    const Eigen::Vector2d& r = track_residuals_[a - range.begin];
    information += J_track.transpose().lazyProduct(J_track);
    gradient += J_track.transpose().lazyProduct(r);
  }
  information.diagonal().array() += kTrackDamping * information.diagonal().maxCoeff();
  // The last parameter of a point is its inverse depth.
  if (D == 3 && pointsAtInfinity()) information(D - 1, D - 1) += kHold;
  const MatrixD L_inverse = information.llt().matrixL().solve(MatrixD::Identity());
  elimination->L_inverse[t] = L_inverse;
  elimination->y[t] = L_inverse.template triangularView<Eigen::Lower>() * gradient;
  for (int a = range.begin; a < range.end; ++a) {
    elimination->K[a] = elimination->K[a].lazyProduct(L_inverse.transpose()).eval();
  }
}

template <int D, typename View>
void VisualInertialProblem::addToPoses(const Track& range, const std::vector<View>& views,
                                       const Eigen::Matrix<double, D, 1>& y,
                                       const Elimination<D>& elimination, System* system) {
  for (int a = range.begin; a < range.end; ++a) {
    const int k_a = views[a].keyframe;
    // The first pose is the gauge: nothing is solved for it.
    if (k_a == 0) continue;
    const Eigen::Matrix<double, 6, 2>& J = elimination.J[a];
    const Eigen::Matrix<double, 2, D>& K = elimination.K[a];
    system->g.segment<6>(6 * k_a) += J * (track_residuals_[a - range.begin] - K * y);
    Eigen::Matrix<double, 6, 6>* blocks = &pose_blocks_[k_a * layout_.n];
    for (int b = range.begin; b < a; ++b) {
      if (views[b].keyframe == 0) continue;
      const Eigen::Matrix2d S = -K * elimination.K[b].transpose();
      const Eigen::Matrix<double, 6, 2> left = J.lazyProduct(S);
      blocks[views[b].keyframe] += left.lazyProduct(elimination.J[b].transpose());
    }
    const Eigen::Matrix2d S = Eigen::Matrix2d::Identity() - K * K.transpose();
    const Eigen::Matrix<double, 6, 2> left = J.lazyProduct(S);
    blocks[k_a] += left.lazyProduct(J.transpose());
  }
}

double VisualInertialProblem::workOfLinearization() const {
  const double m = layout_.size(), per_pair = rolling_ ? kWorkPerRollingPair : kWorkPerPairOfViews;
  double work = kWorkOfSolve * m * m;
  for (const std::vector<Track>* tracks : {&points_.ranges, &lines_.ranges}) {
    for (const Track& track : *tracks) {
      work += track.size() * (kWorkPerView + per_pair * (track.size() + 1.0) / 2.0);
    }
  }
  return work;
}

void VisualInertialProblem::linearize(const WindowState& state, Structure* structure,
                                      System* system) {
  const int n = layout_.n;
  if (budget_ != nullptr) budget_->spend(workOfLinearization());
  system->H.setZero(layout_.size(), layout_.size());
  system->g.setZero(layout_.size());
  pose_blocks_.assign(n * n, Eigen::Matrix<double, 6, 6>::Zero());
  if (rolling_) row_blocks_.assign(n * n, RowBlocks());
  const double line_cost = addTracks(lines_, state, &structure->lines, &system->lines, system);
  system->visual_cost =
      addTracks(points_, state, &structure->points, &system->points, system) + line_cost;
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b <= a; ++b) system->H.block<6, 6>(6 * a, 6 * b) = pose_blocks_[a * n + b];
  }
  if (rolling_) addRowBlocks(system);
  system->visual_H = system->H.topLeftCorner(6 * n, 6 * n);
  system->visual_g = system->g.head(6 * n);
  system->inertial_cost = addInertial(state, system) + addPriors(state, system);
  const double speed_cost = addSpeeds(state, system);
  const RigPriorTerm rig = rigPriorTerm(priors_.rig, state.rig);
  system->H.bottomRightCorner<StateLayout::kRig, StateLayout::kRig>() += rig.H;
  system->g.tail<StateLayout::kRig>() += rig.g;
  system->cost = system->visual_cost + system->inertial_cost + speed_cost + rig.cost;
  if (priors_.known) system->cost += addKnownState(state, system);
}

VisualInertialProblem::Structure VisualInertialProblem::moveStructure(
    const System& system, const Eigen::VectorXd& step) const {
  // Back substitution: L^T d = -(y + sum V^T step).
  const auto move = [this, &step](const auto& tracks, const auto& elimination, auto* parameters) {
    for (std::size_t t = 0; t < tracks.ranges.size(); ++t) {
      auto rhs = elimination.y[t];
      for (int a = tracks.ranges[t].begin; a < tracks.ranges[t].end; ++a) {
        const int k = tracks.views[a].keyframe;
        Eigen::Vector2d moved = elimination.J[a].transpose() * step.segment<6>(6 * k);
        if (by_row_) {
          Eigen::Vector4d row_step;
          row_step << step.segment<3>(layout_.velocity(k)), step[layout_.readout()];
          moved += elimination.rows[a] * row_step;
        }
        rhs += elimination.K[a].transpose() * moved;
      }
      rhs = (elimination.L_inverse[t].transpose() * rhs).eval();
      (*parameters)[t] = (*parameters)[t].moved(-rhs);
    }
  };
  Structure moved = structure_;
  move(points_, system.points, &moved.points);
  move(lines_, system.lines, &moved.lines);
  return moved;
}

std::optional<double> VisualInertialProblem::gaussNewtonStep(double damping,
                                                             Eigen::VectorXd* step) const {
  const int m = layout_.size() - StateLayout::kGauge;
  Eigen::VectorXd x;
  if (!solveDamped(system_.H.bottomRightCorner(m, m), system_.g.tail(m), damping, &x)) {
    return std::nullopt;
  }
  step->setZero(layout_.size());
  step->tail(m) = -x;
  return x.dot(system_.g.tail(m));
}

MapSummary VisualInertialProblem::minimize(int max_iterations, double tolerance,
                                           WindowState* state) {
  triangulateAll(*state);
  return resume(max_iterations, tolerance, state);
}

MapSummary VisualInertialProblem::resume(int max_iterations, double tolerance, WindowState* state) {
  MapSummary summary;
  if (!whitening_valid_) return summary;
  linearize(*state, &structure_, &system_);
  // Not minimizeLevenbergMarquardt(): the last step is taken without an evaluation, a matrix that
  // is not positive definite raises the damping, and systems of this size are swapped, not copied.
  double damping = kFirstDamping;
  bool refused = false;  // the step before
  Eigen::VectorXd step = Eigen::VectorXd::Zero(layout_.size());
  const auto isCut = [this] { return budget_ != nullptr && budget_->isUsedUp(); };
  const auto goesOn = [&] { return summary.iterations < max_iterations && !summary.converged; };
  for (; goesOn() && !isCut(); ++summary.iterations) {
    const std::optional<double> decrement = gaussNewtonStep(damping, &step);
    if (!decrement) {
      damping = 100.0 * std::max(damping, kFirstDamping);
      continue;
    }
    // The last step is not worth a linearisation: cost and information are those before it. Nothing
    // corrects after it what damping holds back, along the scale.
    summary.converged = *decrement < tolerance;
    if (summary.converged && damping > kSmallestDamping) gaussNewtonStep(kSmallestDamping, &step);
    const WindowState trial_state = retract(*state, step);
    Structure trial_structure = moveStructure(system_, step);
    if (!summary.converged) {
      linearize(trial_state, &trial_structure, &trial_);
      if (!(trial_.cost <= system_.cost)) {
        damping = 10.0 * std::max(damping, kFirstDamping);
        refused = true;
        continue;
      }
      std::swap(system_, trial_);
      // Smaller at once, the next step would be refused again.
      if (!refused) damping = std::max(0.1 * damping, kSmallestDamping);
      refused = false;
    }
    *state = trial_state;
    std::swap(structure_, trial_structure);
  }
  static_cast<MapCost&>(summary) = system_;
  if (!summary.converged) step.setZero();
  keepInformation(step);
  final_state_ = *state;
  const bool ended = goesOn() && isCut();
  if (ended) budget_->leaveOut("the end of a minimisation");
  summary.valid = std::isfinite(summary.cost) && information_.allFinite() && !ended;
  return summary;
}

void VisualInertialProblem::keepInformation(const Eigen::VectorXd& last_step) {
  const int m = layout_.size() - StateLayout::kGauge;
  information_ = system_.H.bottomRightCorner(m, m).selfadjointView<Eigen::Lower>();
  visual_information_ = system_.visual_H.selfadjointView<Eigen::Lower>();
  visual_gradient_ = system_.visual_g + visual_information_ * last_step.head(6 * layout_.n);
}

MapResiduals VisualInertialProblem::residuals() const {
  MapResiduals out;
  out.point_tracks = static_cast<int>(points_.ranges.size());
  out.line_tracks = static_cast<int>(lines_.ranges.size());
  const auto measure = [this](const auto& tracks, const auto& parameters, auto view,
                              const auto& norm, std::vector<double>* residuals) {
    RowJacobian by_row;
    residuals->reserve(tracks.views.size());
    for (std::size_t t = 0; t < tracks.ranges.size(); ++t) {
      for (int a = tracks.ranges[t].begin; a < tracks.ranges[t].end; ++a) {
        evaluateView(tracks.views[a], parameters[t], final_state_, 1.0, &view, &by_row);
        residuals->push_back(norm(view.r));
      }
    }
  };
  measure(
      points_, structure_.points, ViewDerivatives<3>(),
      [](const Eigen::Vector2d& r) { return r.norm(); }, &out.points);
  measure(
      lines_, structure_.lines, ViewDerivatives<4>(),
      [](const Eigen::Vector2d& r) { return r.cwiseAbs().maxCoeff(); }, &out.lines);
  return out;
}

int VisualInertialProblem::reject(MapResiduals now, double max_point, double max_line) {
  // No point lies behind the camera, and most do if gravity and motion are turned about: it is as
  // far away as it can be.
  int behind = 0;
  ViewDerivatives<3> view;
  RowJacobian by_row;
  for (std::size_t t = 0; t < points_.ranges.size(); ++t) {
    PointParameters far = structure_.points[t];
    if (!(far.inverse_depth < 0.0)) continue;
    far.inverse_depth = 0.0;
    behind += points_.ranges[t].size();
    for (int a = points_.ranges[t].begin; a < points_.ranges[t].end; ++a) {
      evaluateView(points_.views[a], far, final_state_, 1.0, &view, &by_row);
      now.points[a] = view.r.norm();
    }
  }
  const auto filter = [](const std::vector<double>& residual, double bound, int min_views,
                         auto* tracks, auto* parameters) {
    // In place: what is kept moves to the front.
    int views = 0;
    std::size_t kept = 0;
    for (std::size_t t = 0; t < tracks->ranges.size(); ++t) {
      Track range = {tracks->ranges[t].id, views, views};
      for (int a = tracks->ranges[t].begin; a < tracks->ranges[t].end; ++a) {
        if (residual[a] <= bound) tracks->views[range.end++] = tracks->views[a];
      }
      if (range.size() < min_views) continue;
      views = range.end;
      tracks->ranges[kept] = range;
      (*parameters)[kept++] = (*parameters)[t];
    }
    tracks->views.resize(views);
    tracks->ranges.resize(kept);
    parameters->resize(kept);
  };
  filter(now.points, max_point, 2, &points_, &structure_.points);
  filter(now.lines, max_line, kMinLineViews, &lines_, &structure_.lines);
  return behind;
}

}  // namespace slim_init
