// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "data/derived_window.h"
#include "support/exact_window.h"

namespace slim_init {
namespace {

class WithObservationsTest : public ::testing::Test {
 protected:
  std::vector<char> keepAll() const {
    return std::vector<char>(window_->pointObservations().size(), kKeepObservation);
  }
  const std::shared_ptr<const InitWindow> window_ = makeExactWindow(ExactWindowOptions()).window;
};

TEST_F(WithObservationsTest, AllKeptIsTheSameWindow) {
  const auto all = withObservations(*window_, keepAll());
  ASSERT_NE(all, nullptr);
  ASSERT_EQ(all->pointTracks().size(), window_->pointTracks().size());
  ASSERT_EQ(all->pointObservations().size(), window_->pointObservations().size());
  for (std::size_t a = 0; a < window_->pointObservations().size(); ++a) {
    EXPECT_EQ(all->pointObservations()[a].bearing, window_->pointObservations()[a].bearing);
    EXPECT_EQ(all->pointObservations()[a].keyframe, window_->pointObservations()[a].keyframe);
  }
}

TEST_F(WithObservationsTest, EverythingButThePointsIsShared) {
  std::vector<char> keep = keepAll();
  keep.front() = kDropObservation;
  const auto fewer = withObservations(*window_, keep);
  ASSERT_NE(fewer, nullptr);
  EXPECT_EQ(&fewer->calibration(), &window_->calibration());
  EXPECT_EQ(fewer->times().data(), window_->times().data());
  EXPECT_EQ(fewer->imu().data(), window_->imu().data());
  EXPECT_EQ(fewer->lineTracks().data(), window_->lineTracks().data());
  EXPECT_EQ(fewer->lineObservations().data(), window_->lineObservations().data());
  EXPECT_EQ(&fewer->linesOfKeyframe(3), &window_->linesOfKeyframe(3));
  EXPECT_NE(fewer->pointObservations().data(), window_->pointObservations().data());
}

TEST_F(WithObservationsTest, SharedPartsOutliveTheFirstWindow) {
  auto first = makeExactWindow(ExactWindowOptions()).window;
  const std::size_t samples = first->imu().size();
  const auto second = withObservations(*first, keepAll());
  first.reset();
  ASSERT_EQ(second->imu().size(), samples);
  EXPECT_EQ(second->imu().back().t, window_->imu().back().t);
  EXPECT_EQ(second->times(), window_->times());
}

TEST_F(WithObservationsTest, NothingKeptLeavesNoTrack) {
  const auto none = withObservations(
      *window_, std::vector<char>(window_->pointObservations().size(), kDropObservation));
  ASSERT_NE(none, nullptr);
  EXPECT_TRUE(none->pointTracks().empty());
  EXPECT_TRUE(none->pointObservations().empty());
  EXPECT_EQ(none->size(), window_->size());
}

TEST_F(WithObservationsTest, ATrackLeftWithOneSightingIsDropped) {
  std::vector<char> keep = keepAll();
  const Track& track = window_->pointTracks()[0];
  for (int a = track.begin + 1; a < track.end; ++a) keep[a] = kDropObservation;
  EXPECT_EQ(withObservations(*window_, keep)->pointTracks().size(),
            window_->pointTracks().size() - 1);
  // With two it stays.
  keep[track.begin + 1] = kKeepObservation;
  const auto two = withObservations(*window_, keep);
  ASSERT_EQ(two->pointTracks().size(), window_->pointTracks().size());
  EXPECT_EQ(two->pointTracks()[0].size(), 2);
}

TEST_F(WithObservationsTest, ACutMakesTwoTracksOfOneId) {
  const auto track = std::find_if(window_->pointTracks().begin(), window_->pointTracks().end(),
                                  [](const Track& t) { return t.size() >= 5; });
  ASSERT_NE(track, window_->pointTracks().end());
  std::vector<char> keep = keepAll();
  keep[track->begin + 2] = kStartTrack;
  const auto cut = withObservations(*window_, keep);
  std::vector<int> sizes;
  for (const Track& t : cut->pointTracks()) {
    if (t.id == track->id) sizes.push_back(t.size());
  }
  EXPECT_EQ(sizes, (std::vector<int>{2, track->size() - 2}));
  EXPECT_EQ(cut->pointObservations().size(), window_->pointObservations().size());
}

TEST_F(WithObservationsTest, AMaskOfAnotherSizeIsRefused) {
  EXPECT_EQ(withObservations(*window_, std::vector<char>(3, kKeepObservation)), nullptr);
  std::vector<char> longer = keepAll();
  longer.push_back(kKeepObservation);
  EXPECT_EQ(withObservations(*window_, longer), nullptr);
}

}  // namespace
}  // namespace slim_init
