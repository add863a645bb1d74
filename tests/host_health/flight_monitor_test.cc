// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/host_health/flight_monitor.h"

#include <gtest/gtest.h>

#include <string>

namespace slim_init::host_health {
namespace {

HostHealth healthy() { return HostHealth(); }
HostHealth confirmed(double stamp) {
  HostHealth health;
  health.confirmed_stamp = stamp;
  return health;
}
HostHealth suspicious() {
  HostHealth health;
  health.suspect = true;
  health.reason = "velocity";
  return health;
}
HostHealth failed() {
  HostHealth health = suspicious();
  health.healthy = false;
  return health;
}

class Monitored : public ::testing::Test {
 protected:
  FlightMonitor monitor_;
};

TEST_F(Monitored, AHealthyFlightSaysNothing) {
  for (double t = 0.0; t < 20.0; t += 0.1) EXPECT_EQ(monitor_.update(t, healthy()), "");
  EXPECT_EQ(monitor_.status(), FlightStatus::kGood);
  EXPECT_FALSE(monitor_.wantsEvidence(20.0));
}

TEST_F(Monitored, AFailureIsReportedOnceAndEndsWithEvidence) {
  EXPECT_EQ(monitor_.update(1.0, failed()), "the host's states are inconsistent: velocity");
  EXPECT_EQ(monitor_.update(1.1, failed()), "");
  EXPECT_EQ(monitor_.status(), FlightStatus::kWrong);
  EXPECT_EQ(monitor_.alarmStamp(), 1.0);
  // Nothing against the states is not the same as something for them.
  for (double t = 1.2; t < 3.0; t += 0.1) EXPECT_EQ(monitor_.update(t, healthy()), "");
  EXPECT_EQ(monitor_.status(), FlightStatus::kWrong);
  EXPECT_TRUE(monitor_.wantsEvidence(3.0));
  EXPECT_NE(monitor_.update(3.0, confirmed(2.9)).find("healthy again"), std::string::npos);
  EXPECT_EQ(monitor_.status(), FlightStatus::kGood);
}

TEST_F(Monitored, EvidenceFromBeforeTheTroubleDoesNotCount) {
  monitor_.update(1.0, failed());
  monitor_.recovered(1.2);
  EXPECT_EQ(monitor_.status(), FlightStatus::kSuspect) << "recovered, and not confirmed yet";
  EXPECT_FALSE(monitor_.wantsEvidence(1.5));
  // A window that ends less than half a second after it has little that is new.
  EXPECT_EQ(monitor_.update(1.6, confirmed(1.6)), "");
  EXPECT_EQ(monitor_.update(1.7, suspicious()), "");
  EXPECT_EQ(monitor_.update(2.1, confirmed(2.1)), "");
  EXPECT_EQ(monitor_.status(), FlightStatus::kSuspect);
  EXPECT_NE(monitor_.update(2.3, confirmed(2.25)), "");
  EXPECT_EQ(monitor_.status(), FlightStatus::kGood);
}

TEST_F(Monitored, DamagedDataAreDoubtedInSilence) {
  monitor_.doubt(1.0);
  EXPECT_EQ(monitor_.status(), FlightStatus::kSuspect);
  EXPECT_EQ(monitor_.update(1.0, healthy()), "");
  EXPECT_EQ(monitor_.update(1.6, confirmed(1.6)), "") << "no failure was reported";
  EXPECT_EQ(monitor_.status(), FlightStatus::kGood);
}

TEST_F(Monitored, AtConstantVelocityNoWindowCanSpeak) {
  monitor_.update(0.0, failed());
  monitor_.recovered(0.1);
  std::string said;
  double t = 0.2;
  for (; said.empty() && t < 60.0; t += 0.1) said = monitor_.update(t, healthy());
  EXPECT_NEAR(t, 0.1 + FlightMonitor::kUnopposed, 0.25);
  EXPECT_EQ(said.find("healthy"), std::string::npos) << said;
  EXPECT_EQ(monitor_.status(), FlightStatus::kGood);
}

TEST_F(Monitored, ANewStartForgets) {
  monitor_.update(0.0, failed());
  monitor_.reset();
  EXPECT_EQ(monitor_.status(), FlightStatus::kGood);
  EXPECT_EQ(monitor_.update(1.0, confirmed(1.0)), "");
}

TEST_F(Monitored, NamesOfAStatus) {
  EXPECT_STREQ(toString(FlightStatus::kGood), "good");
  EXPECT_STREQ(toString(FlightStatus::kSuspect), "suspect");
  EXPECT_STREQ(toString(FlightStatus::kWrong), "wrong");
}

}  // namespace
}  // namespace slim_init::host_health
