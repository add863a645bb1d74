// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Message stamps of a live system: late messages, stray stamps, a bag that starts again. No ROS
// here.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace slim_init::node {

/// What to do with a message, judged by its stamp alone.
enum class StampVerdict {
  kUse,      ///< in order
  kNoStamp,  ///< zero, negative or not finite: drop
  kLate,     ///< not after the message before: drop
  kHeld,     ///< far from the message before; a second one there makes it a jump: drop
  kStale,    ///< of the time before a jump that another stream has made: drop
  kRestart,  ///< time has jumped: forget the data of all streams, then use the message
};

/// What became of the messages of one stream.
struct StampCounts {
  std::int64_t used = 0;
  std::int64_t no_stamp = 0;
  std::int64_t late = 0;
  std::int64_t held = 0;
  std::int64_t stale = 0;

  std::int64_t dropped() const { return no_stamp + late + held + stale; }
};

/// Judges the stamps of streams that share one time.
///
/// A stamp more than `kJump` away from the one before is not believed until the next message agrees
/// with it: a single wrong stamp costs one message, and a bag that starts again costs one as well.
/// Time that went back is a restart for all streams; time that went forward (messages were lost)
/// only for a stream that asks for it. After a restart the other streams' messages of the old time
/// are stale, for as long as `kPatience` of their time: a sender that lags is still in the old
/// time, but a stream that goes on for longer has a clock of its own.
class TimeGuard {
 public:
  static constexpr double kJump = 1.0;      ///< [s], the host's own bound for images
  static constexpr double kPatience = 5.0;  ///< [s]

  struct Stream {
    bool restart_on_gap = false;  ///< also a jump forward is a restart
  };
  explicit TimeGuard(const std::vector<Stream>& streams);

  /// `stream`: index into the constructor's list; `t`: header stamp [s].
  StampVerdict check(int stream, double t);

  /// Forgets the times, as before the first message; the counts stay.
  void forget();

  const StampCounts& counts(int stream) const { return states_[stream].counts; }
  std::int64_t restarts() const { return restarts_; }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  struct State {
    bool restart_on_gap = false;
    double last = kNone;
    double held = kNone;
    bool following = false;  // another stream has jumped, this one not yet
    double first_stale = kNone;
    StampCounts counts;
  };

  StampVerdict use(State* state, double t);

  std::vector<State> states_;
  double newest_ = kNone;  // of any stream since the last restart
  std::int64_t restarts_ = 0;
};

}  // namespace slim_init::node
