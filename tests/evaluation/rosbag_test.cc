// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Bags: what is written is read back; bags that others wrote, whole and broken.
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "evaluation/image_files.h"
#include "evaluation/scratch_folder.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/options.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

ros::Time rosTime(std::int64_t stamp_ns) {
  return ros::Time(static_cast<std::uint32_t>(stamp_ns / 1000000000),
                   static_cast<std::uint32_t>(stamp_ns % 1000000000));
}

sensor_msgs::Imu imuMessage(int k) {
  const ImuSample sample = TinyRecording::imu(k);
  sensor_msgs::Imu message;
  message.header.stamp = rosTime(TinyRecording::kT0Ns + k * TinyRecording::kImuStepNs);
  message.angular_velocity.x = sample.gyro.x();
  message.angular_velocity.y = sample.gyro.y();
  message.angular_velocity.z = sample.gyro.z();
  message.linear_acceleration.x = sample.accel.x();
  message.linear_acceleration.y = sample.accel.y();
  message.linear_acceleration.z = sample.accel.z();
  return message;
}

sensor_msgs::CompressedImage compressedMessage(int k) {
  sensor_msgs::CompressedImage message;
  message.header.stamp = rosTime(TinyRecording::kT0Ns + k * TinyRecording::kImageStepNs);
  message.format = "mono8; png compressed";
  cv::imencode(".png", TinyRecording::image(k), message.data);
  return message;
}

/// A message with the pixels of `image`, rows padded by `padding` bytes.
sensor_msgs::Image imageMessage(int k, const cv::Mat& image, const std::string& encoding,
                                int padding = 0) {
  sensor_msgs::Image message;
  message.header.stamp = rosTime(TinyRecording::kT0Ns + k * TinyRecording::kImageStepNs);
  message.width = static_cast<std::uint32_t>(image.cols);
  message.height = static_cast<std::uint32_t>(image.rows);
  message.encoding = encoding;
  const std::size_t row = image.cols * image.elemSize();
  message.step = static_cast<std::uint32_t>(row + padding);
  for (int y = 0; y < image.rows; ++y) {
    message.data.insert(message.data.end(), image.ptr(y), image.ptr(y) + row);
    message.data.insert(message.data.end(), padding, 0xAA);
  }
  return message;
}

/// Recorded at its stamp.
template <typename Message>
void put(const std::string& topic, const Message& message, rosbag::Bag* bag) {
  bag->write(topic, message.header.stamp, message);
}

class RosbagTest : public ::testing::Test {
 protected:
  std::string file() const { return folder_.file("tiny.bag"); }

  void writeTiny() const {
    TinyRecording::write(folder_.file("asl"), TinyRecording::rig());
    ASSERT_EQ(evaluation::writeBag(folder_.file("asl"), BagTopics(), file()), "");
  }

  /// A bag with IMU messages and whatever `images` writes.
  void writeBag(const std::function<void(rosbag::Bag&)>& images) const {
    rosbag::Bag bag(file(), rosbag::bagmode::Write);
    writeImu(&bag);
    images(bag);
  }
  static void writeImu(rosbag::Bag* bag) {
    for (int k = 0; k < TinyRecording::kImuSamples; ++k) put("/imu0", imuMessage(k), bag);
  }
  /// Three images of a few pixels.
  static void writeSmallImages(rosbag::Bag* bag) {
    const cv::Mat image(4, 6, CV_8UC1, cv::Scalar(7));
    for (int k = 0; k < 3; ++k) put("/cam0/image_raw", imageMessage(k, image, "mono8"), bag);
  }

  std::unique_ptr<ImageSequence> open(const BagTopics& topics = BagTopics(),
                                      const std::string& truth = "") {
    return openRosbag(file(), topics, truth, WindowOptions().max_imu_gap_s, &status_);
  }

  /// The same of a bag that is in order.
  std::unique_ptr<ImageSequence> opened(const BagTopics& topics = BagTopics()) {
    auto sequence = open(topics);
    if (sequence == nullptr) throw std::runtime_error(status_.message);
    return sequence;
  }

  ScratchFolder folder_;
  ReadStatus status_;
};

TEST_F(RosbagTest, ReadsBackWhatWasWritten) {
  writeTiny();
  const auto sequence =
      open({"/imu0", "/cam0/image_raw", "/speed0", true}, groundtruthFileOf(file()));
  ASSERT_NE(sequence, nullptr) << status_.message;
  TinyRecording::expectIn(sequence.get());
  EXPECT_EQ(sequence->name, "tiny");
  EXPECT_TRUE(sequence->notes.empty()) << sequence->notes.front();
}

// By which a node counts what was lost.
TEST_F(RosbagTest, MessagesOfATopicAreNumbered) {
  writeTiny();
  const rosbag::Bag bag(file(), rosbag::bagmode::Read);
  std::uint32_t next = 0;
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery("/imu0"))) {
    EXPECT_EQ(message.instantiate<sensor_msgs::Imu>()->header.seq, next++);
  }
  EXPECT_EQ(next, static_cast<std::uint32_t>(TinyRecording::kImuSamples));
}

// nav_msgs/Odometry has a frame and a pose before the velocity; all three components are measured.
TEST_F(RosbagTest, VelocitiesOfOdometry) {
  writeBag([](rosbag::Bag& bag) {
    for (int k = 0; k < TinyRecording::kImages; ++k) {
      put("/cam0/image_raw", compressedMessage(k), &bag);
    }
    for (const int k : {1, 0, 1}) {
      nav_msgs::Odometry message;
      message.header.stamp = rosTime(TinyRecording::kT0Ns + k * 100000000);
      message.child_frame_id = "base_link";
      message.pose.pose.position.x = 7.0;
      message.twist.twist.linear.x = 1.0 + k;
      message.twist.twist.linear.y = -0.5;
      for (int i = 0; i < 36; ++i) message.twist.covariance[i] = i;
      put("/odom", message, &bag);
    }
    bag.write("/imu1", rosTime(TinyRecording::kT0Ns), imuMessage(0));
  });
  BagTopics topics = {"/imu0", "/cam0/image_raw", "odom", false};
  const auto sequence = opened(topics);
  ASSERT_EQ(sequence->speeds.size(), 2u);
  const SpeedSample& second = sequence->speeds[1];
  EXPECT_NEAR(second.t, 0.1, 1e-12);
  EXPECT_EQ(second.velocity, Eigen::Vector3d(2.0, -0.5, 0.0));
  EXPECT_EQ(second.covariance(1, 2), 8.0);
  EXPECT_FALSE(second.forward_only);
  EXPECT_TRUE(contains(sequence->notes.front(), "velocities")) << sequence->notes.front();
  topics.speed = "/wheel";
  const auto without = open(topics);
  ASSERT_NE(without, nullptr) << status_.message;
  EXPECT_TRUE(without->speeds.empty());
  expectParts(without->notes.front(), "no topic /wheel|speed_topic");
  topics.speed = "/imu1";
  EXPECT_EQ(open(topics), nullptr);
  expectParts(status_.message, "speed_topic|/imu1|sensor_msgs/Imu|nav_msgs/Odometry");
}

TEST_F(RosbagTest, WithoutTruthAndWithoutLeadingSlashes) {
  writeTiny();
  const auto sequence = opened({"imu0", "cam0/image_raw", "", true});
  EXPECT_TRUE(sequence->truth.empty());
  EXPECT_EQ(sequence->images(), static_cast<std::size_t>(TinyRecording::kImages));
}

TEST_F(RosbagTest, EncodingsBecomeTheGreyOfOpenCv) {
  cv::Mat bgr(48, 64, CV_8UC3);
  cv::RNG random(7);
  random.fill(bgr, cv::RNG::UNIFORM, 0, 256);
  cv::Mat grey, rgb, bgra, rgba;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  cv::cvtColor(bgr, bgra, cv::COLOR_BGR2BGRA);
  cv::cvtColor(bgr, rgba, cv::COLOR_BGR2RGBA);
  writeBag([&](rosbag::Bag& bag) {
    int k = 0;
    const auto write = [&](const sensor_msgs::Image& message) {
      put("/cam0/image_raw", message, &bag);
      ++k;
    };
    for (const int padding : {0, 5}) {
      write(imageMessage(k, grey, "mono8", padding));
      write(imageMessage(k, bgr, "bgr8", padding));
      write(imageMessage(k, rgb, "rgb8", padding));
      write(imageMessage(k, bgra, "bgra8", padding));
      write(imageMessage(k, rgba, "rgba8", padding));
    }
  });
  const auto sequence = opened();
  ASSERT_EQ(sequence->images(), 10u);
  for (std::size_t k = 0; k < 10; ++k) {
    std::string error;
    const cv::Mat read = sequence->image(k, &error);
    ASSERT_EQ(read.type(), CV_8UC1) << error;
    EXPECT_EQ(cv::norm(read, grey, cv::NORM_INF), 0.0) << "image " << k;
  }
}

TEST_F(RosbagTest, CompressedImagesAreDecodedAndFoundBesideTheRawTopic) {
  writeBag([](rosbag::Bag& bag) {
    for (int k = 0; k < 3; ++k) {
      sensor_msgs::CompressedImage message = compressedMessage(k);
      if (k == 2) message.data.resize(20);
      put("/cam0/image_raw/compressed", message, &bag);
    }
  });
  for (const char* topic : {"/cam0/image_raw", "/cam0/image_raw/compressed"}) {
    const auto sequence = opened({"/imu0", topic, "", true});
    EXPECT_EQ(cv::norm(sequence->image(1, nullptr), TinyRecording::image(1), cv::NORM_INF), 0.0);
    expectNoImage(sequence.get(), 2, "cannot be decoded: 20 bytes");
  }
}

TEST_F(RosbagTest, ImagesThatCannotBeUsedAreNamed) {
  writeBag([](rosbag::Bag& bag) {
    std::vector<sensor_msgs::Image> messages = {
        imageMessage(0, TinyRecording::image(0), "mono8"),
        imageMessage(1, TinyRecording::image(1), "bayer_rggb16"),
        imageMessage(2, TinyRecording::image(2), "mono8"),
        imageMessage(3, TinyRecording::image(3), "mono8"),
        imageMessage(4, TinyRecording::image(4), "bgr8")};  // a third of the bytes it needs
    messages[2].data.resize(100);
    messages[3].height = 4000000000u;
    for (const sensor_msgs::Image& message : messages) put("/cam0/image_raw", message, &bag);
  });
  const auto sequence = opened();
  EXPECT_FALSE(sequence->image(0, nullptr).empty());
  const std::string topic = "/cam0/image_raw at |";
  expectNoImage(sequence.get(), 1, topic + "encoding 'bayer_rggb16', must be mono8");
  expectNoImage(sequence.get(), 2, topic + "holds 100 bytes");
  expectNoImage(sequence.get(), 3, topic + "64 x 4000000000");
  expectNoImage(sequence.get(), 4, topic + "bgr8");
}

TEST_F(RosbagTest, MissingTopicsAreListedWithThoseThatAreThere) {
  writeTiny();
  EXPECT_EQ(open({"/imu0", "/camera/image", "", true}), nullptr);
  expectParts(status_.message,
              "tiny.bag has no topic '/camera/image' (image_topic)|/imu0 "
              "(sensor_msgs/Imu)|/cam0/image_raw (sensor_msgs/Image)");
  EXPECT_EQ(open({"/cam0/image_raw", "/cam0/image_raw", "", true}), nullptr);
  expectParts(status_.message, "imu_topic /cam0/image_raw carries 'sensor_msgs/Image'");
}

TEST_F(RosbagTest, DisorderIsSortedRepeatsAndNotFiniteAreDropped) {
  writeBag([](rosbag::Bag& bag) {
    // Recorded in this order, stamped in another.
    const std::int64_t t = TinyRecording::kT0Ns;
    int recorded = 0;
    for (const int k : {0, 2, 1, 2, 3}) {
      sensor_msgs::Image message = imageMessage(k, TinyRecording::image(k), "mono8");
      bag.write("/cam0/image_raw", rosTime(t + 1000 * ++recorded), message);
    }
    sensor_msgs::Imu nan = imuMessage(7);
    nan.header.stamp = rosTime(t + 12345);
    nan.linear_acceleration.y = std::nan("");
    put("/imu0", nan, &bag);
    sensor_msgs::Imu twice = imuMessage(9);
    bag.write("/imu0", rosTime(t + 2000000000), twice);
  });
  const auto sequence = opened();
  ASSERT_EQ(sequence->images(), 4u);
  EXPECT_EQ(sequence->image_disorder.out_of_order, 1);
  EXPECT_EQ(sequence->image_disorder.repeated, 1);
  EXPECT_EQ(sequence->imu_disorder.unreadable, 1);
  EXPECT_EQ(sequence->imu_disorder.repeated, 1);
  EXPECT_EQ(sequence->imu.size(), static_cast<std::size_t>(TinyRecording::kImuSamples));
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(cv::norm(sequence->image(k, nullptr), TinyRecording::image(static_cast<int>(k)),
                       cv::NORM_INF),
              0.0)
        << k;
  }
  std::string notes;
  for (const std::string& note : sequence->notes) notes += note + "\n";
  expectParts(notes, "1 images out of order|not finite");
}

TEST_F(RosbagTest, ABagCutShortAnywhereIsRefusedWithASentence) {
  writeTiny();
  const std::string whole = readFile(file());
  ASSERT_NE(open(), nullptr) << status_.message;
  for (const double share : {0.0, 0.0001, 0.01, 0.3, 0.6, 0.9, 0.999}) {
    folder_.write("tiny.bag", whole.substr(0, static_cast<std::size_t>(share * whole.size())));
    EXPECT_EQ(open(), nullptr) << share;
    expectParts(status_.message, "tiny.bag cannot be opened as a bag");
  }
  folder_.write("tiny.bag", "this is no bag\n");
  EXPECT_EQ(open(), nullptr);
  std::filesystem::remove(file());
  EXPECT_EQ(open(), nullptr);
  expectParts(status_.message, "does not exist");
}

TEST_F(RosbagTest, DamagedMessagesAreDroppedOrNamed) {
  writeTiny();
  std::string bytes = readFile(file());
  const auto damage = [&bytes](const std::string& what, int occurrence, const std::string& with) {
    std::size_t at = bytes.find(what);
    for (int i = 0; i < occurrence && at != std::string::npos; ++i) at = bytes.find(what, at + 1);
    ASSERT_NE(at, std::string::npos) << what;
    bytes.replace(at, with.size(), with);
  };
  // Lengths before a text: of the header's frame, and of the encoding.
  const std::string huge = "\xff\xff\xff\x7f";
  damage(std::string("\x04\0\0\0cam0", 8), 3, huge);
  damage(std::string("\x05\0\0\0mono8", 9), 5, huge);
  damage(std::string("\x04\0\0\0imu0", 8), 10, huge);
  folder_.write("tiny.bag", bytes);
  const auto sequence = opened();
  EXPECT_EQ(sequence->image_disorder.unreadable, 1);
  EXPECT_EQ(sequence->imu_disorder.unreadable, 1);
  EXPECT_EQ(sequence->imu.size(), TinyRecording::kImuSamples - 1u);
  ASSERT_EQ(sequence->images(), static_cast<std::size_t>(TinyRecording::kImages - 1));
  expectNoImage(sequence.get(), 4, "cannot be read");
  EXPECT_EQ(cv::norm(sequence->image(5, nullptr), TinyRecording::image(6), cv::NORM_INF), 0.0);
}

std::uint32_t numberAt(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, &bytes[at], sizeof(value));
  return value;
}

// Where the data of the first index record of a bag begin: times and offsets, twelve bytes each.
std::size_t firstIndex(const std::string& bytes) {
  for (std::size_t at = 13; at + 4 < bytes.size();) {
    const std::size_t length = numberAt(bytes, at);
    const std::string header = bytes.substr(at + 4, length);
    const std::size_t data = at + 4 + length + 4;
    if (contains(header, "op=\x04")) return data;
    at = data + numberAt(bytes, data - 4);
  }
  return std::string::npos;
}

// The rosbag library would follow the entry. Whatever the chunks are packed with.
TEST_F(RosbagTest, AnIndexThatLeadsOutOfItsChunkIsRefused) {
  for (const auto compression :
       {rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    SCOPED_TRACE(static_cast<int>(compression));
    {
      rosbag::Bag bag(file(), rosbag::bagmode::Write);
      bag.setCompression(compression);
      writeImu(&bag);
      writeSmallImages(&bag);
    }
    ASSERT_NE(open(), nullptr) << status_.message;
    std::string bytes = readFile(file());
    const std::size_t index = firstIndex(bytes);
    ASSERT_LT(index + 12, bytes.size());
    for (const std::uint32_t offset : {std::uint32_t{0x7fffffff}, std::uint32_t{2}}) {
      std::memcpy(&bytes[index + 8], &offset, sizeof(offset));
      std::ofstream(file(), std::ios::binary | std::ios::trunc) << bytes;
      EXPECT_EQ(open(), nullptr);
      expectParts(status_.message, "it is damaged");
    }
  }
}

// The library parses what it takes for headers without looking at their lengths.
TEST_F(RosbagTest, LengthsAndPlacesOfHeadersAreChecked) {
  writeTiny();
  const std::string whole = readFile(file());
  const auto refused = [&](std::string bytes, std::size_t at, const std::string& with) {
    ASSERT_LT(at + with.size(), bytes.size());
    bytes.replace(at, with.size(), with);
    std::ofstream(file(), std::ios::binary | std::ios::trunc) << bytes;
    EXPECT_EQ(open(), nullptr) << at;
    EXPECT_NE(status_.message, "");
  };
  const std::string huge("\xff\xff\x07\0", 4);
  // The list of connections and chunks a byte further on, and one chunk too many in it.
  const std::size_t summary = whole.find("index_pos=") + 10;
  refused(whole, summary, std::string(1, static_cast<char>(whole[summary] + 1)));
  refused(whole, whole.find("chunk_count=") + 12, "\x09");
  // A field of the last connection, which is in that list, and of the first message.
  refused(whole, whole.rfind("type=sensor_msgs/") - 4, huge);
  const std::size_t first = whole.find("op=\x02") - 4;
  refused(whole, first, huge);
  // No message where the index says so: another kind of record, and a connection.
  for (const char op : {'\x01', '\x07', '\x00'}) refused(whole, first + 7, std::string(1, op));
  // Chunks of a connection that are not all there.
  refused(whole, whole.rfind("count=") + 6, "\x07");
}

// The message code of ROS would reserve as many bytes as the length of the pixels says.
TEST_F(RosbagTest, TheLengthOfThePixelsIsChecked) {
  const auto refused = [this](const std::string& before, const std::string& topic) {
    std::string bytes = readFile(file());
    const std::size_t at = bytes.find(before);
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at + before.size(), 4, "\xff\xff\xff\x7f");
    folder_.write("tiny.bag", bytes);
    const auto sequence = opened({"/imu0", topic, "", true});
    expectNoImage(sequence.get(), 0, "said to have 2147483647 bytes of pixels, ");
    std::string error;
    EXPECT_FALSE(sequence->image(1, &error).empty()) << error;
  };
  writeTiny();
  // After the encoding: the order of the bytes, and the length of a row.
  const auto row = static_cast<char>(TinyRecording::image(0).cols);
  refused("mono8" + std::string(1, '\0') + row + std::string(3, '\0'), "/cam0/image_raw");
  writeBag([](rosbag::Bag& bag) {
    for (int k = 0; k < 3; ++k) put("/cam0/image_raw/compressed", compressedMessage(k), &bag);
  });
  refused("mono8; png compressed", "/cam0/image_raw/compressed");
}

// What the rosbag library writes otherwise: nothing, many chunks with a connection that begins
// late, and a bag that was opened again.
TEST_F(RosbagTest, UnusualBagsAreRead) {
  { const rosbag::Bag bag(file(), rosbag::bagmode::Write); }
  EXPECT_EQ(open(), nullptr);
  expectParts(status_.message, "topic");
  {
    rosbag::Bag bag(file(), rosbag::bagmode::Write);
    bag.setChunkThreshold(2000);
    writeImu(&bag);
  }
  {
    rosbag::Bag bag(file(), rosbag::bagmode::Append);
    writeSmallImages(&bag);
  }
  const auto sequence = opened();
  EXPECT_EQ(sequence->imu.size(), static_cast<std::size_t>(TinyRecording::kImuSamples));
  EXPECT_EQ(sequence->images(), 3U);
}

TEST_F(RosbagTest, WriterRefusesWhatABagCannotHold) {
  for (const std::int64_t t0_ns : {std::int64_t{0}, std::int64_t{4294967296000000000}}) {
    const std::string asl = folder_.file("asl" + std::to_string(t0_ns));
    TinyRecording::write(asl, TinyRecording::rig(), TinyRecording::recording(t0_ns));
    expectParts(evaluation::writeBag(asl, BagTopics(), file()), "tiny.bag cannot be written");
  }
  writeTiny();
  folder_.write("occupied", "");
  expectParts(
      evaluation::writeBag(folder_.file("asl"), BagTopics(), folder_.file("occupied/x.bag")),
      "occupied/x.bag cannot be written");
  expectParts(evaluation::writeBag(folder_.file("none"), BagTopics(), file()),
              "none is not a directory");
}

}  // namespace
}  // namespace slim_init::evaluation
