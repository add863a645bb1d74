// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The bytes are one of the three tables of a recording without images; the first says which.

#include "fuzz_target.h"
#include "slim_init/evaluation/recorded.h"

using slim_init::evaluation::readRecordedMotion;
using slim_init::evaluation::ReadStatus;
using slim_init::evaluation::RecordedMotion;

namespace {

constexpr char kImu[] =
    "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n"
    "1000000000,0,0,0,9.8,0,0\n1005000000,0,0,0.1,9.8,0,0\n1300000000,0,0,0,9.8,0,0.1\n";
constexpr char kImages[] = "#timestamp [ns]\n1050000000\n1100000000\n1150000000\n";
constexpr char kTruth[] =
    "#timestamp [ns],p_x,p_y,p_z,q_w,q_x,q_y,q_z\n"
    "1000000000,0,0,0,1,0,0,0\n1100000000,0.1,0,0,1,0,0,0\n1200000000,0.2,0,0,1,0,0,0\n"
    "1300000000,0.3,0,0,1,0,0,0\n";

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const slim_init::fuzz::Folder folder;
  slim_init::fuzz::Bytes bytes(data, size);
  const int which = bytes.below(3);
  const std::string text = bytes.rest();
  folder.write("imu0.csv", which == 0 ? text : kImu);
  folder.write("cam0_timestamps.csv", which == 1 ? text : kImages);
  folder.write("groundtruth.csv", which == 2 ? text : kTruth);
  RecordedMotion motion;
  const ReadStatus status = readRecordedMotion(folder.path(), 0.05, &motion);
  FUZZ_CHECK(status.ok() || !status.message.empty(), "refused without a word");
  for (std::size_t i = 0; status.ok() && i < motion.imu.size(); ++i) {
    FUZZ_CHECK(motion.imu[i].gyro.allFinite() && motion.imu[i].accel.allFinite(), i);
    FUZZ_CHECK(i == 0 || motion.imu[i].t > motion.imu[i - 1].t, i);
  }
  return 0;
}
