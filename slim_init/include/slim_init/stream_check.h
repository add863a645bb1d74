// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is checked about every message before it becomes data, and what was dropped. One class for
// ROS nodes, host adapter and command line.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "slim_init/types.h"

namespace slim_init {

/// What became of one message.
enum class AddStatus {
  kAdded,
  kRestarted,      ///< time had jumped: all earlier data was dropped, then the message was added
  kNotFinite,      ///< NaN or infinity in time, gyro or accelerometer: dropped and counted
  kGlitch,         ///< IMU sample beyond ImuLimits, speed beyond kMaxSpeed: dropped and counted
  kOutOfOrder,     ///< time not after the previous message of its kind: dropped and counted
  kStray,          ///< time more than StreamCheck::kJump from its stream, not confirmed by another
                   ///< message yet: dropped and counted
  kBeforeJump,     ///< from before a jump in time that another stream has made: dropped and counted
  kWaiting,        ///< lines whose frame has not come yet: kept for it
  kUnmatched,      ///< lines whose frame is unknown or has lines already: dropped and counted
  kNotSupported,   ///< lines or a speed, passed to an initializer that does not use them
  kNoCovariance,   ///< speed whose covariance is not positive definite: dropped and counted
  kNotCalibrated,  ///< speed of a sensor without extrinsics (SpeedSensor): dropped and counted
};

/// True where the message is data now.
inline bool isAdded(AddStatus status) {
  return status == AddStatus::kAdded || status == AddStatus::kRestarted;
}

/// True where it has been lost.
inline bool isDropped(AddStatus status) {
  return !isAdded(status) && status != AddStatus::kWaiting;
}

/// Why a message is not data, in a few words, e.g. "late"; stable.
const char* toString(AddStatus status);

/// What became of the messages of one stream: a count of each status.
class MessageCounts {
 public:
  std::int64_t& operator[](AddStatus status) { return counts_[static_cast<std::size_t>(status)]; }
  std::int64_t operator[](AddStatus status) const {
    return counts_[static_cast<std::size_t>(status)];
  }
  /// Those that are data.
  std::int64_t added() const;
  MessageCounts& operator+=(const MessageCounts& other);
  /// Counts `status` and returns it.
  AddStatus count(AddStatus status);

  static constexpr int kStatuses = static_cast<int>(AddStatus::kNotCalibrated) + 1;

 private:
  std::array<std::int64_t, kStatuses> counts_{};
};

/// What was received and what was dropped, from the sensors to the keyframe window; nothing
/// disappears without a count. The only such structure: InitWindow, IInitializer, host adapter, ROS
/// nodes and the reports of the command line all hand out this one.
struct StreamCounts {
  MessageCounts imu, frames, speeds;
  MessageCounts lines;  ///< kUnmatched: the frame never came, too; kWaiting: so many are kept now
  std::int64_t observations_not_finite = 0;    ///< point or line with NaN/inf or a zero bearing
  std::int64_t observations_duplicate_id = 0;  ///< second use of an id within one frame
  std::int64_t lines_degenerate = 0;           ///< end points less than 1e-6 rad apart

  /// Jumps in time; each dropped all data before it.
  std::int64_t restarts() const {
    return imu[AddStatus::kRestarted] + frames[AddStatus::kRestarted];
  }
  StreamCounts& operator+=(const StreamCounts& other);
};

/// What `now` has dropped more than `before`, e.g. "2 IMU samples (late), 1 frame (not finite)";
/// "": nothing.
std::string droppedSince(const StreamCounts& before, const StreamCounts& now);

/// How a stream is checked.
struct StreamOptions {
  ImuLimits imu;
  /// Data that arrives while it is used: a stamp far from its stream is a stray one until another
  /// message confirms it, and time that jumps back is a restart. Off, as for a recording that was
  /// read, sorted and checked as a whole: gaps are gaps, and what is not after its predecessor is
  /// dropped.
  bool live = false;
  /// A confirmed gap of more than StreamCheck::kJump between frames is a restart as well. For
  /// trackers, which cannot match across it. Without `live` it has no effect.
  bool restart_on_frame_gap = false;

  /// Streams of a running system.
  static StreamOptions liveData(const ImuLimits& imu = ImuLimits());
};

/// Judges IMU samples and frames by their values and stamps. It keeps no data: its owner drops all
/// earlier data on kRestarted and uses the message where isAdded(). Not thread-safe.
///
/// Live streams: a stamp more than kJump from the previous one of its stream is believed when a
/// second message agrees: the next one of the stream or, for a gap, the newest one of the other
/// stream. So an incorrect stamp (but a stream's first) costs one message, as does a bag's restart.
/// Time that went back is a restart for both streams; by less than kJump, once messages in a row
/// have been late for kLate of their time. The other stream's messages of the old time (more than
/// kLate ahead and nearer to it, or kJump off) are then dropped for kPatience of their time: who
/// goes on for longer has a clock of its own.
class StreamCheck {
 public:
  static constexpr double kJump = 1.0;        ///< [s]; VINS-Mono's own bound for images
  static constexpr double kPatience = 5.0;    ///< [s]
  static constexpr double kLate = 0.08;       ///< [s]; two images of a host at 10 Hz
  static constexpr double kMaxSpeed = 100.0;  ///< [m/s]; no vehicle of a camera rig is faster

  explicit StreamCheck(const StreamOptions& options = StreamOptions()) : options_(options) {}

  /// `sample.t` [s] on the IMU clock.
  AddStatus checkImu(const ImuSample& sample);
  /// `t` [s] on a clock less than kJump off the IMU clock.
  AddStatus checkFrame(double t);

  /// A speed is no clock: one with a stamp more than kJump from the other live streams is dropped
  /// (kStray), and never a reason to restart.
  AddStatus checkSpeed(const SpeedSample& sample, const SpeedSensor& sensor);

  /// Forgets the times, as before the first message; the counts stay.
  void forgetTimes();

  const StreamOptions& options() const { return options_; }
  const StreamCounts& counts() const { return counts_; }
  /// For the owner's own drops: lines, observations.
  StreamCounts& counts() { return counts_; }

 private:
  /// One of the input streams.
  struct Stream {
    double last = kNotComputed;
    double stray = kNotComputed;        // the last unconfirmed stamp
    double late = kNotComputed;         // the last of late messages in a row, each after the one
    double late_since = kNotComputed;   // before, and the first of them
    bool follows_jump = false;          // the other stream has jumped, this one not yet
    double first_stale = kNotComputed;  // first message from before that jump
  };

  AddStatus checkTime(double t, bool restart_on_gap, Stream* stream);
  AddStatus use(double t, Stream* stream);
  AddStatus restart(double t, Stream* stream);

  StreamOptions options_;
  StreamCounts counts_;
  Stream imu_, frames_;
  double newest_ = kNotComputed;      // of both streams since the last restart
  double before_ = kNotComputed;      // of both before it, if time went back
  double last_speed_ = kNotComputed;  // likewise
};

}  // namespace slim_init
