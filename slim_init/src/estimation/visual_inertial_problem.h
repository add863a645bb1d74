// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Structureless visual-inertial maximum a posteriori estimate of a window (docs/derivation.md).
//
// Minimises over the keyframe states, both biases and the gravity direction
//   sum |IMU residual|^2  +  sum rho(|point residual|^2) + sum rho(|line residual|^2)
//   + accelBiasTerm(b_a) + |b_g|^2 / sigma_bg^2,
// each whitened, rho the Cauchy loss; and over the errors of extrinsics, td and readout time under
// their prior (inertial_factor.h), with a prior on the motion (MotionPrior), with measured
// velocities of the window (speed_factor.h), and with a known state of the first body in place of
// the priors of the biases (state_factor.h). The parameters of every track are eliminated inside
// each Gauss-Newton step (Schur complement), which is the same step as on their null space.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/speed_factor.h"
#include "estimation/state_factor.h"
#include "estimation/visual_tracks.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "lines/line_track.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/work_budget.h"

namespace slim_init {

/// The robust cost at a state, and its parts.
struct MapCost {
  double cost = 0.0;           ///< the whole
  double visual_cost = 0.0;    ///< from points and lines
  double inertial_cost = 0.0;  ///< from IMU factors, biases and motion prior
  double rotation_cost = 0.0;  ///< of that from the rotations between keyframes
};

/// What the minimisation reports.
struct MapSummary : MapCost {
  bool valid = false;      ///< finite, and the information of the state is positive definite
  bool converged = false;  ///< the last step was shorter than the tolerance
  int iterations = 0;
};

/// Residuals of the observations that take part, at a state.
struct MapResiduals {
  std::vector<double> points;  ///< per active point view: |r| [rad]
  std::vector<double> lines;   ///< per active line view: largest |sine| of both ends [rad]
  int point_tracks = 0;
  int line_tracks = 0;
};

/// The problem of one window. Holds the observations that take part and the scratch of their
/// elimination; one object serves several starts and the solve after the rejection of outliers.
class VisualInertialProblem {
 public:
  /// `lines`: ranges of window.lineObservations() (window.lineTracks(), or what
  /// agreeingLineTracks() left of them). `pre`: one preintegration per consecutive pair, with
  /// covariance; kept by reference. Lines take part only as `options` says.
  VisualInertialProblem(const InitWindow& window, const std::vector<Track>& lines,
                        const std::vector<Preintegration>& pre, const RefinementOptions& options,
                        const InertialOptions& inertial, const WindowPriors& priors = {});

  /// Counts the work of what follows; a minimisation ends where it is used up, and is not valid.
  /// Null: nothing is counted.
  void setBudget(WorkBudget* budget) { budget_ = budget; }

  /// To be called after the caller has changed the preintegrations: they are now between the
  /// keyframe times moved by `td_shift` [s].
  void setPreintegrated(double td_shift);

  /// Standard deviation of a point bearing and of a line end point across the line [rad].
  void setNoise(double sigma_point_rad, double sigma_line_rad);
  double sigmaPoint() const { return points_.sigma; }
  double sigmaLine() const { return lines_.sigma; }

  /// Levenberg-Marquardt from `state`; track parameters are triangulated from it first. `state` is
  /// the best found, also where the minimisation failed. Ends where the squared length of a step is
  /// below `tolerance` [sigma^2].
  MapSummary minimize(int max_iterations, double tolerance, WindowState* state);

  /// Continues from the state and the track parameters that the last call left.
  MapSummary resume(int max_iterations, double tolerance, WindowState* state);

  /// Residuals after minimize(), at its answer.
  MapResiduals residuals() const;

  /// Removes observations beyond the bounds [rad], and tracks left with fewer than two point or
  /// three line views. `now` as residuals() gave it; a point behind the camera counts as one at
  /// infinity. Returns the views of such points.
  int reject(MapResiduals now, double max_point, double max_line);

  /// What has become of the measured velocities, at the answer of minimize().
  SpeedUse speedUse() const;

  int pointViews() const { return static_cast<int>(points_.views.size()); }
  /// Visual residuals minus track parameters.
  int visualDof() const;

  /// Information matrix of the error vector without the gauge (StateLayout, from index kGauge on)
  /// at the answer of minimize(), tracks eliminated.
  const Eigen::MatrixXd& information() const { return information_; }

  /// Its part from points and lines, 6N x 6N of the poses [theta_k, p_k], tracks
  /// eliminated; and half the derivative of their cost by the poses at the answer. Those of the
  /// gauge, which nothing needs, are zero. Neither depends on the IMU but through the state at
  /// which they are taken.
  const Eigen::MatrixXd& visualInformation() const { return visual_information_; }
  const Eigen::VectorXd& visualGradient() const { return visual_gradient_; }

 private:
  /// The tracks of one kind that take part.
  template <typename View>
  struct Tracks {
    std::vector<Track> ranges;  ///< of `views`
    std::vector<View> views;
    double sigma = 0.0;  ///< standard deviation of a residual [rad]
  };
  /// What the elimination of the tracks of one kind (D parameters each) leaves for the back
  /// substitution: per track the inverse of the factor L of its information and y = L^-1 gradient,
  /// per view J_pose^T and K = J_track L^-T, whose products with those of other views are what the
  /// track takes off the poses. All rows weighted by the root of the robust weight.
  template <int D>
  struct Elimination {
    std::vector<Eigen::Matrix<double, D, D>> L_inverse;
    std::vector<Eigen::Matrix<double, D, 1>> y;
    std::vector<Eigen::Matrix<double, 6, 2>> J;
    std::vector<Eigen::Matrix<double, 2, D>> K;
    std::vector<RowJacobian> rows;  ///< by velocity and readout; empty with a global shutter
  };
  /// What the tracks couple of two keyframes a >= b through the velocities in a rolling shutter.
  struct RowBlocks {
    Eigen::Matrix<double, 3, 6> pose = Eigen::Matrix<double, 3, 6>::Zero();  ///< v of a, pose of b
    Eigen::Matrix<double, 3, 6> other_pose = Eigen::Matrix<double, 3, 6>::Zero();  ///< v of b, a
    Eigen::Matrix3d velocity = Eigen::Matrix3d::Zero();                            ///< of both
  };
  /// Parameters of all tracks.
  struct Structure {
    std::vector<PointParameters> points;
    std::vector<LineParameters> lines;
  };
  /// Normal equations at a state; H is the lower triangle.
  struct System : MapCost {
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
    Eigen::MatrixXd visual_H;  // part of the poses from the tracks, lower triangle
    Eigen::VectorXd visual_g;
    Elimination<3> points;
    Elimination<4> lines;
  };

  bool pointsAtInfinity() const { return priors_.known && priors_.known->points_at_infinity; }
  double workOfLinearization() const;
  void triangulateAll(const WindowState& state);
  double addPriors(const WindowState& state, System* system) const;
  double addKnownState(const WindowState& state, System* system) const;
  std::vector<SpeedResidual> speedResiduals(const WindowState& state) const;
  double addSpeeds(const WindowState& state, System* system) const;
  double addInertial(const WindowState& state, System* system);
  double addInertialFactor(int i, const Eigen::Matrix<double, 9, 1>& residual,
                           const Eigen::Matrix<double, 9, kRigInertialColumns>& jacobian,
                           System* system) const;
  template <int D, typename View, typename Parameters>
  double addTracks(const Tracks<View>& tracks, const WindowState& state,
                   std::vector<Parameters>* parameters, Elimination<D>* elimination,
                   System* system);
  /// Evaluates and factors track `t`; its cost.
  template <int D, typename View, typename Parameters>
  double evaluateTrack(const Tracks<View>& tracks, std::size_t t, const Parameters& parameters,
                       const WindowState& state, Elimination<D>* elimination);
  /// Factors the information of track `t`; J_track of its views, in `elimination->K`, becomes K.
  template <int D>
  void factorTrack(const Track& range, std::size_t t, Elimination<D>* elimination) const;
  /// What is left of a factored track for the poses of its views.
  template <int D, typename View>
  void addToPoses(const Track& range, const std::vector<View>& views,
                  const Eigen::Matrix<double, D, 1>& y, const Elimination<D>& elimination,
                  System* system);
  template <int D, typename View>
  void eliminateRows(const Track& track, const std::vector<View>& views,
                     const Eigen::Matrix<double, D, 1>& y, const Elimination<D>& elimination,
                     System* system);
  template <typename View, typename Parameters, int D>
  void evaluateView(const View& view, const Parameters& parameters, const WindowState& state,
                    double sqrt_information, ViewDerivatives<D>* out, RowJacobian* by_row) const;
  void addRowBlocks(System* system) const;
  void linearize(const WindowState& state, Structure* structure, System* system);
  Structure moveStructure(const System& system, const Eigen::VectorXd& step) const;
  /// The damped step, zero along the gauge, and its squared length in standard deviations of the
  /// state; none, and no step, where the matrix is not positive definite. Unlike the decrease of
  /// the cost that length is blind to outliers that still creep along the flat tail of the loss.
  std::optional<double> gaussNewtonStep(double damping, Eigen::VectorXd* step) const;
  /// Of the last linearisation; the gradient after `last_step`, which was not worth another.
  void keepInformation(const Eigen::VectorXd& last_step);

  const InitWindow& window_;
  WorkBudget* budget_ = nullptr;
  const std::vector<Preintegration>& pre_;
  RefinementOptions options_;
  InertialOptions inertial_;
  StateLayout layout_;
  std::vector<Eigen::Matrix<double, 9, 9>> whitening_;
  bool whitening_valid_ = true;
  Eigen::Vector3d t_b_c_;
  double readout_s_;
  bool rolling_;  // rows are exposed one after the other
  bool by_row_;   // the readout time is known, or estimated
  WindowPriors priors_;
  StateCovariance known_information_ = StateCovariance::Zero();
  std::vector<SpeedFactor> speeds_;
  double td_shift_ = 0.0;              // of the preintegrations [s]
  std::vector<ImuInstant> instants_;   // at the ends of the preintegrations
  WindowState nominal_;                // scratch of addInertial()
  std::vector<RigDerivatives> chain_;  // likewise

  Tracks<PointView> points_;
  Tracks<LineView> lines_;
  Structure structure_;
  System system_, trial_;
  std::vector<Eigen::Matrix<double, 6, 6>> pose_blocks_;  // scratch of addTracks()
  std::vector<Eigen::Vector2d> track_residuals_;          // likewise, of one track
  std::vector<RowBlocks> row_blocks_;                     // likewise, with a rolling shutter
  WindowState final_state_;
  Eigen::MatrixXd information_;
  Eigen::MatrixXd visual_information_;
  Eigen::VectorXd visual_gradient_;
};

}  // namespace slim_init
