// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Bags of ROS 1 through the rosbag library. Everything that library and its message code may throw
// ends in this file.
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/TwistWithCovarianceStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <filesystem>
#include <limits>
#include <map>
#include <stdexcept>
#include <type_traits>

#include "datasets/csv_table.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/feature_tracker_lines/image_message.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr char kImuType[] = "sensor_msgs/Imu";
constexpr char kImageType[] = "sensor_msgs/Image";
constexpr char kCompressedType[] = "sensor_msgs/CompressedImage";
constexpr char kTwistType[] = "geometry_msgs/TwistWithCovarianceStamped";
constexpr char kOdometryType[] = "nav_msgs/Odometry";

std::string withoutSlash(const std::string& topic) {
  return topic.substr(std::min(topic.find_first_not_of('/'), topic.size()));
}

std::int64_t stampOf(const ros::Time& time) {
  return std::int64_t{1000000000} * time.sec + time.nsec;
}

/// A message as it was sent.
std::vector<std::uint8_t> bytesOf(const rosbag::MessageInstance& message) {
  std::vector<std::uint8_t> bytes(message.size());
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  message.write(out);
  return bytes;
}

/// Why a bag cannot be read, or an empty string. The library believes every length and offset in
/// the file: a damaged one makes it ask for gigabytes or read outside its memory. A child process
/// takes every message out once, with the same steps as this process will, and ends in its place.
std::string bagDamage(const std::string& file) {
  enum Outcome { kSound, kDamaged, kUnindexed };
  const pid_t child = fork();
  if (child == 0) {
    Outcome outcome = kDamaged;
    try {
      rosbag::Bag bag(file);
      rosbag::View all(bag);
      for (const rosbag::MessageInstance& message : all) bytesOf(message);
      outcome = kSound;
    } catch (const rosbag::BagUnindexedException&) {
      outcome = kUnindexed;
    } catch (const std::exception&) {
    }
    _exit(outcome);
  }
  int status = -1;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (!WIFEXITED(status)) return "it is damaged";
  const int outcome = WEXITSTATUS(status);
  return outcome == kSound ? "" : outcome == kUnindexed ? "it has no index" : "it is damaged";
}

ros::serialization::IStream streamOf(std::vector<std::uint8_t>* bytes) {
  return {bytes->data(), static_cast<std::uint32_t>(bytes->size())};
}

/// Header of a message of any type that begins with one, as ours do. The pixels are read from the
/// file but not taken apart.
std::int64_t headerStampNs(const rosbag::MessageInstance& message) {
  std::vector<std::uint8_t> bytes = bytesOf(message);
  ros::serialization::IStream in = streamOf(&bytes);
  std_msgs::Header header;
  ros::serialization::deserialize(in, header);
  return stampOf(header.stamp);
}

/// Velocity and covariance of a kTwistType or kOdometryType; returns the stamp.
std::int64_t readTwist(const rosbag::MessageInstance& message, SpeedSample* sample) {
  std::vector<std::uint8_t> bytes = bytesOf(message);
  ros::serialization::IStream in = streamOf(&bytes);
  std_msgs::Header header;
  in.next(header);
  if (message.getDataType() == kOdometryType) {
    std::string child_frame;
    geometry_msgs::PoseWithCovariance pose;
    in.next(child_frame);
    in.next(pose);
  }
  geometry_msgs::TwistWithCovariance twist;
  in.next(twist);
  const geometry_msgs::Vector3& v = twist.twist.linear;
  sample->velocity = Eigen::Vector3d(v.x, v.y, v.z);
  sample->covariance =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(twist.covariance.data())
          .topLeftCorner<3, 3>();
  return stampOf(header.stamp);
}

/// Grey image of a message, or a sentence about it.
template <typename Message>
std::string decodeMessage(const rosbag::MessageInstance& instance, cv::Mat* grey, double* largest) {
  if (!instance.isType<Message>()) return "is of another version of its type";
  std::vector<std::uint8_t> bytes = bytesOf(instance);
  ros::serialization::IStream in = streamOf(&bytes);
  Message message;
  constexpr bool kCompressed = std::is_same_v<Message, sensor_msgs::CompressedImage>;
  in.next(message.header);
  if constexpr (kCompressed) {
    in.next(message.format);
  } else {
    in.next(message.height);
    in.next(message.width);
    in.next(message.encoding);
    in.next(message.is_bigendian);
    in.next(message.step);
  }
  // The message code reserves what the length says, up to 4 GB, before it looks what is there.
  ros::serialization::IStream pixels = in;
  std::uint32_t length = 0;
  pixels.next(length);
  if (length > pixels.getLength()) {
    return text("is said to have ", length, " bytes of pixels, ", pixels.getLength(),
                " are left of its message");
  }
  in.next(message.data);
  if constexpr (kCompressed) {
    return feature_tracker_lines::decodeCompressedImage(message, grey, largest);
  } else {
    return feature_tracker_lines::decodeImage(message, grey, largest);
  }
}

class BagFile : public ImageSequence {
 public:
  void open(const std::string& file, const BagTopics& topics, const std::string& groundtruth_file,
            double max_imu_gap_s) {
    file_ = file;
    name = fs::path(lastComponent(file)).stem().string();
    std::error_code code;
    if (!fs::is_regular_file(file, code)) {
      fail(file, fs::exists(file, code) ? " is not a regular file" : " does not exist");
    }
    if (const std::string damage = bagDamage(file); !damage.empty()) {
      fail(file, " cannot be opened as a bag of ROS 1: ", damage,
           "; if its recording was cut short, `rosbag reindex` repairs it");
    }
    try {
      bag_.open(file, rosbag::bagmode::Read);
      readMessages(topics, groundtruth_file, max_imu_gap_s);
    } catch (const std::exception& exception) {
      fail(file, " cannot be read: ", exception.what());
    }
  }

  cv::Mat image(std::size_t k, std::string* sentence) override {
    const rosbag::MessageInstance& message = image_messages_[message_of_image_[k]];
    cv::Mat grey;
    std::string problem;
    try {
      problem = message.getDataType() == kImageType
                    ? decodeMessage<sensor_msgs::Image>(message, &grey, &largest_)
                    : decodeMessage<sensor_msgs::CompressedImage>(message, &grey, &largest_);
    } catch (const std::exception& exception) {
      problem = std::string("cannot be read: ") + exception.what();
    }
    if (problem.empty()) return grey;
    if (sentence != nullptr) {
      *sentence = text(file_, ": image of ", message.getTopic(), " at ", stampNs(image_times[k]),
                       " ns ", problem);
    }
    return cv::Mat();
  }

 private:
  /// The topic of the bag that is meant by `wanted`, which carries one of `types`. An image topic
  /// may also be there in its compressed form only.
  std::string findTopic(const std::map<std::string, std::string>& known, const std::string& key,
                        const std::string& wanted, const std::vector<std::string>& types) {
    for (const std::string suffix : {"", "/compressed"}) {
      if (!suffix.empty() && types.size() < 2) continue;
      for (const auto& [topic, type] : known) {
        if (withoutSlash(topic) != withoutSlash(wanted) + suffix) continue;
        if (std::find(types.begin(), types.end(), type) == types.end()) {
          fail(file_, ": ", key, " ", wanted, " carries ", quoted(type), ", must be ",
               types.front(), types.size() > 1 ? " or " + types[1] : "");
        }
        if (!suffix.empty()) notes.push_back(file_ + ": " + wanted + " is there as " + topic);
        return topic;
      }
    }
    std::string list;
    for (const auto& [topic, type] : known) {
      list += text(list.empty() ? "" : ", ", topic, " (", type, ")");
    }
    fail(file_, " has no topic ", quoted(wanted), " (", key, "); it has ",
         list.empty() ? "none" : list);
  }

  void readMessages(const BagTopics& topics, const std::string& groundtruth_file,
                    double max_imu_gap_s) {
    std::map<std::string, std::string> known;
    {
      rosbag::View all(bag_);
      for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
        known[connection->topic] = connection->datatype;
      }
    }
    const std::string imu_topic = findTopic(known, "imu_topic", topics.imu, {kImuType});
    const std::string image_topic =
        findTopic(known, "image_topic", topics.image, {kImageType, kCompressedType});
    const bool has_speeds = std::any_of(known.begin(), known.end(), [&](const auto& topic) {
      return withoutSlash(topic.first) == withoutSlash(topics.speed);
    });
    if (!topics.speed.empty() && !has_speeds) {
      notes.push_back(file_ + " has no topic " + topics.speed + " (speed_topic): no velocities");
    }
    std::string speed_topic;
    if (has_speeds) {
      speed_topic = findTopic(known, "speed_topic", topics.speed, {kTwistType, kOdometryType});
    }
    readImu(imu_topic, max_imu_gap_s);
    if (has_speeds) readSpeeds(speed_topic, topics.speed_forward_only);
    readImageStamps(image_topic);
    if (!groundtruth_file.empty()) readTruth(groundtruth_file, this);
  }

  template <typename Value>
  struct Stamped {
    std::int64_t stamp_ns = 0;
    Value value;
  };

  /// What `read(message, &value)` makes of the messages of a view, by stamp, which it returns.
  /// Messages at which it throws are counted, and notes say how many these are and which are not in
  /// order. `what` is the plural of the messages.
  template <typename Value, typename Read>
  std::vector<Stamped<Value>> readTopic(rosbag::View* view, const std::string& topic,
                                        const std::string& what, const Read& read,
                                        Disorder* disorder) {
    std::vector<Stamped<Value>> values;
    int unreadable = 0;
    for (const rosbag::MessageInstance& message : *view) {
      try {
        Stamped<Value> stamped;
        stamped.stamp_ns = read(message, &stamped.value);
        values.push_back(stamped);
      } catch (const std::exception&) {
        ++unreadable;
      }
    }
    *disorder = sortByStamp(&values);
    disorder->unreadable = unreadable;
    noteDisorder(file_ + " " + topic, what, *disorder, &notes);
    return values;
  }

  void checkCount(const std::string& topic, std::size_t count, std::size_t minimum) const {
    if (count >= minimum) return;
    fail(file_, ": ", topic, " has ", count, " usable messages (minimum ", minimum, ")");
  }

  void readImu(const std::string& topic, double max_imu_gap_s) {
    const auto read = [](const rosbag::MessageInstance& instance, ImuSample* sample) {
      const sensor_msgs::Imu::ConstPtr message = instance.instantiate<sensor_msgs::Imu>();
      if (message == nullptr) throw std::runtime_error("another version of the type");
      const auto vector = [](const geometry_msgs::Vector3& v) {
        return Eigen::Vector3d(v.x, v.y, v.z);
      };
      sample->gyro = vector(message->angular_velocity);
      sample->accel = vector(message->linear_acceleration);
      if (!sample->gyro.allFinite() || !sample->accel.allFinite()) {
        throw std::runtime_error("not finite");
      }
      return stampOf(message->header.stamp);
    };
    rosbag::View view(bag_, rosbag::TopicQuery(topic));
    auto samples = readTopic<ImuSample>(&view, topic, "IMU messages", read, &imu_disorder);
    checkCount(topic, samples.size(), kMinImuSamples);
    t0_ns = samples.front().stamp_ns;
    for (Stamped<ImuSample>& sample : samples) {
      sample.value.t = relativeSeconds(sample.stamp_ns, t0_ns);
      imu.push_back(sample.value);
    }
    noteImuGaps(file_ + ": " + topic, imu, max_imu_gap_s, /*table=*/nullptr, &notes);
  }

  void readSpeeds(const std::string& topic, bool forward_only) {
    Disorder disorder;
    rosbag::View view(bag_, rosbag::TopicQuery(topic));
    for (Stamped<SpeedSample>& speed :
         readTopic<SpeedSample>(&view, topic, "velocities", readTwist, &disorder)) {
      speed.value.forward_only = forward_only;
      speed.value.t = relativeSeconds(speed.stamp_ns, t0_ns);
      speeds.push_back(speed.value);
    }
  }

  void readImageStamps(const std::string& topic) {
    image_view_ = std::make_unique<rosbag::View>(bag_, rosbag::TopicQuery(topic));
    // Messages themselves can be copied, but not moved about: sorted are their places.
    const auto read = [this](const rosbag::MessageInstance& message, std::size_t* place) {
      const std::int64_t stamp_ns = headerStampNs(message);
      *place = image_messages_.size();
      image_messages_.push_back(message);
      return stamp_ns;
    };
    for (const Stamped<std::size_t>& image :
         readTopic<std::size_t>(image_view_.get(), topic, "images", read, &image_disorder)) {
      image_times.push_back(relativeSeconds(image.stamp_ns, t0_ns));
      message_of_image_.push_back(image.value);
    }
    checkCount(topic, images(), kMinImages);
  }

  std::string file_;
  rosbag::Bag bag_;
  double largest_ = 0.0;                                 // of 16-bit images
  std::unique_ptr<rosbag::View> image_view_;             ///< the messages below point into it
  std::vector<rosbag::MessageInstance> image_messages_;  ///< as recorded
  std::vector<std::size_t> message_of_image_;
};

// ------------------------------------------------------------------------------------- writing

/// Throws.
void writeMessages(ImageSequence* sequence, const BagTopics& topics, rosbag::Bag* bag) {
  const auto write = [bag](const std::string& topic, const char* frame, std::size_t number,
                           std::int64_t stamp_ns, auto message) {
    message.header.seq = static_cast<std::uint32_t>(number);
    message.header.frame_id = frame;
    message.header.stamp.fromNSec(static_cast<std::uint64_t>(stamp_ns));
    bag->write(topic, message.header.stamp, message);
  };
  const auto fill = [](const Eigen::Vector3d& from, geometry_msgs::Vector3* to) {
    to->x = from.x();
    to->y = from.y();
    to->z = from.z();
  };
  for (std::size_t k = 0; k < sequence->imu.size(); ++k) {
    const ImuSample& sample = sequence->imu[k];
    sensor_msgs::Imu message;
    fill(sample.gyro, &message.angular_velocity);
    fill(sample.accel, &message.linear_acceleration);
    message.orientation_covariance[0] = -1.0;  // no orientation, by the message's own definition
    write(topics.imu, "imu0", k, sequence->stampNs(sample.t), message);
  }
  for (std::size_t k = 0; k < sequence->speeds.size(); ++k) {
    const SpeedSample& sample = sequence->speeds[k];
    geometry_msgs::TwistWithCovarianceStamped message;
    message.twist.twist.linear.x = sample.velocity.x();
    message.twist.covariance[0] = sample.covariance(0, 0);
    write(topics.speed.empty() ? "/speed0" : topics.speed, "speed0", k, sequence->stampNs(sample.t),
          message);
  }
  for (std::size_t k = 0; k < sequence->images(); ++k) {
    std::string problem;
    const cv::Mat image = sequence->image(k, &problem);
    if (!problem.empty()) throw std::runtime_error(problem);
    sensor_msgs::Image message;
    message.height = static_cast<std::uint32_t>(image.rows);
    message.width = static_cast<std::uint32_t>(image.cols);
    message.encoding = "mono8";
    message.step = message.width;
    message.data.assign(image.datastart, image.datastart + image.total());
    write(topics.image, "cam0", k, sequence->stampNs(sequence->image_times[k]), message);
  }
}

}  // namespace

bool rosbagSupported() { return true; }

std::unique_ptr<ImageSequence> openRosbag(const std::string& file, const BagTopics& topics,
                                          const std::string& groundtruth_file, double max_imu_gap_s,
                                          ReadStatus* status) {
  auto bag = std::make_unique<BagFile>();
  *status = statusOf([&] { bag->open(file, topics, groundtruth_file, max_imu_gap_s); });
  if (!status->ok()) return nullptr;
  return bag;
}

std::string writeBag(const std::string& asl_directory, const BagTopics& topics,
                     const std::string& file) {
  ReadStatus status;
  const auto sequence =
      openAslFolder(asl_directory, std::numeric_limits<double>::infinity(), &status);
  if (sequence == nullptr) return status.message;
  try {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    writeMessages(sequence.get(), topics, &bag);
    bag.close();
    if (sequence->truth.empty()) return "";
    fs::copy_file(fs::path(asl_directory) / "mav0/state_groundtruth_estimate0/data.csv",
                  groundtruthFileOf(file), fs::copy_options::overwrite_existing);
  } catch (const std::exception& exception) {
    return file + " cannot be written: " + exception.what();
  }
  return "";
}

}  // namespace slim_init::evaluation
