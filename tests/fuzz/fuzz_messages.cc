// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The bytes are a point or a line message of any shape, as a tracker may send it.
#include <iterator>
#include <vector>

#include "fuzz_target.h"
#include "slim_init/vins_adapter/feature_message.h"

namespace {

namespace adapter = slim_init::vins_adapter;

// The members of sensor_msgs::PointCloud.
struct Cloud {
  struct Header {
    struct Stamp {
      double seconds = 0.0;
      double toSec() const { return seconds; }
    } stamp;
  } header;
  struct Point {
    float x = 0.0f, y = 0.0f, z = 0.0f;
  };
  struct Channel {
    std::string name;
    std::vector<float> values;
  };
  std::vector<Point> points;
  std::vector<Channel> channels;
};

Cloud makeCloud(slim_init::fuzz::Bytes* bytes, bool lines) {
  Cloud cloud;
  cloud.header.stamp.seconds = bytes->number(100.0);
  cloud.points.resize(bytes->below(6));
  for (Cloud::Point& point : cloud.points) {
    point.x = static_cast<float>(bytes->number(1.0));
    point.y = static_cast<float>(bytes->number(1.0));
    point.z = bytes->byte() < 250 ? 1.0f : static_cast<float>(bytes->number(1.0));
  }
  const int usual = lines ? static_cast<int>(std::size(adapter::kLineChannels))
                          : static_cast<int>(std::size(adapter::kPointChannels));
  cloud.channels.resize(bytes->byte() < 250 ? usual : bytes->below(20));
  for (int c = 0; c < static_cast<int>(cloud.channels.size()); ++c) {
    if (lines && c < usual) cloud.channels[c].name = adapter::kLineChannels[c];
    cloud.channels[c].values.resize(bytes->byte() < 250 ? cloud.points.size() : bytes->below(9));
    for (float& value : cloud.channels[c].values) {
      value =
          c == 0 && bytes->byte() < 250 ? bytes->byte() : static_cast<float>(bytes->number(100.0));
    }
  }
  return cloud;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  slim_init::fuzz::Bytes bytes(data, size);
  slim_init::FrameObservation frame;
  std::string error;
  const Cloud points = makeCloud(&bytes, false);
  if (adapter::readPointMessage(points, &frame, &error)) {
    for (const auto& point : frame.points) FUZZ_CHECK(point.bearing.allFinite(), point.id);
    Cloud written;
    FUZZ_CHECK(adapter::writePointMessage(frame, &frame, &written, &error) || !error.empty(),
               "refused without a word");
  } else {
    FUZZ_CHECK(!error.empty(), "refused without a word");
  }
  error.clear();
  const Cloud lines = makeCloud(&bytes, true);
  if (adapter::readLineMessage(lines, &frame, &error)) {
    Cloud written;
    FUZZ_CHECK(adapter::writeLineMessage(frame, &written, &error) || !error.empty(),
               "refused without a word");
  } else {
    FUZZ_CHECK(!error.empty(), "refused without a word");
  }
  return 0;
}
