// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Images and IMU in, VINS-Mono's feature messages and our lines out (docs/ros.md). Can replace that
// host's own tracker.
#include <ros/ros.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud.h>
#include <std_msgs/Bool.h>

#include <exception>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <string>

#include "slim_init/feature_tracker_lines/image_message.h"
#include "slim_init/ros/conversions.h"
#include "slim_init/ros/image_pipeline.h"
#include "slim_init/ros/node_parameters.h"
#include "slim_init/ros/stream_monitor.h"
#include "slim_init/text.h"
#include "slim_init/vins_adapter/feature_message.h"

namespace slim_init::node {
namespace {

constexpr char kCameraFrame[] = "camera";

class FeatureTrackerLinesNode {
 public:
  /// Returns an empty string, or a message why the node cannot run.
  std::string start();

 private:
  enum Stream { kImu, kImage };

  void onImu(const sensor_msgs::Imu& message);
  void onImage(const sensor_msgs::Image& message);
  void onCompressed(const sensor_msgs::CompressedImage& message);

  template <typename Message, typename Decode>
  void addImage(const Message& message, const Decode& decode);
  void use(AddStatus status);
  void publishRestart();
  void publish(const TrackedFrame& tracked);
  void publishDebugImage(const std_msgs::Header& header);
  Diagnostics::Statuses diagnostics();

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_{"~"};
  ImuLimits imu_limits_;
  cv::Size image_size_;
  double largest_ = 0.0;               // of 16-bit images
  std::int64_t discarded_before_ = 0;  // images, at the last report
  std::unique_ptr<ImagePipeline> pipeline_;
  NodeStreams streams_{{{"imu", &StreamCounts::imu, true}, {"image", &StreamCounts::frames, true}}};

  ros::Subscriber imu_, image_;
  ros::Publisher features_, lines_, restart_, debug_image_;
  Diagnostics diagnostics_;
};

std::string FeatureTrackerLinesNode::start() {
  Config config;
  ImagePipelineOptions options;
  NodeParameters parameters(private_handle_);
  parameters.readConfig(&config);
  options.publish_rate_hz = config.front_end.host.freq;
  std::string transport = "raw";
  parameters.readTopic("imu_topic", &config.imu_topic);
  parameters.readTopic("image_topic", &config.image_topic);
  parameters.read("image_transport", &transport);
  parameters.read("image_queue", &options.image_queue);
  parameters.read("max_imu_wait_s", &options.max_imu_wait_s);
  parameters.read("publish_rate_hz", &options.publish_rate_hz);
  // Of the launch files of VINS-Mono and GVINS, for their own trackers.
  parameters.acceptUnused("vins_folder");
  parameters.acceptUnused("gvins_folder");
  if (std::string problem = parameters.check(); !problem.empty()) return problem;
  if (std::string problem = options.validate(); !problem.empty()) return "~" + problem;
  if (transport != "raw" && transport != "compressed") {
    return "~image_transport is \"" + transport + "\", must be raw or compressed";
  }
  parameters.log();
  // One thread: OpenCV's own cost more than they save at these image sizes.
  cv::setNumThreads(1);
  imu_limits_ = config.options.imu;
  image_size_ = {config.camera.width, config.camera.height};
  pipeline_ = std::make_unique<ImagePipeline>(config, options);

  features_ = handle_.advertise<sensor_msgs::PointCloud>("feature_tracker/feature", 100);
  lines_ = handle_.advertise<sensor_msgs::PointCloud>("feature_tracker_lines/lines", 100);
  restart_ = handle_.advertise<std_msgs::Bool>("feature_tracker/restart", 10);
  debug_image_ = handle_.advertise<sensor_msgs::Image>("feature_tracker/feature_img", 2);
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  imu_ = handle_.subscribe(config.imu_topic, 2000, &FeatureTrackerLinesNode::onImu, this, hints);
  const auto queue = static_cast<std::uint32_t>(options.image_queue);
  if (transport == "raw") {
    image_ = handle_.subscribe(config.image_topic, queue, &FeatureTrackerLinesNode::onImage, this,
                               hints);
  } else {
    image_ = handle_.subscribe(config.image_topic + "/compressed", queue,
                               &FeatureTrackerLinesNode::onCompressed, this, hints);
  }
  diagnostics_.start([this] { return diagnostics(); });
  return "";
}

void FeatureTrackerLinesNode::publishRestart() {
  std_msgs::Bool message;
  message.data = true;
  restart_.publish(message);
}

void FeatureTrackerLinesNode::onImu(const sensor_msgs::Imu& message) {
  ImuSample sample;
  const std::string problem = readImu(message, &sample);
  if (!streams_.accept(kImu, message.header, problem, &sample.t)) return;
  const AddStatus status = pipeline_->addImu(sample);
  if (status == AddStatus::kGlitch) streams_.explain(kImu, imu_limits_.describe(sample));
  use(status);
}

template <typename Message, typename Decode>
void FeatureTrackerLinesNode::addImage(const Message& message, const Decode& decode) {
  cv::Mat image;
  std::string problem;
  try {
    problem = decode(message, &image, &largest_);
  } catch (const std::exception& exception) {
    problem = std::string("cannot be read: ") + exception.what();
  }
  if (problem.empty() && image.size() != image_size_) {
    problem = text("has ", image.cols, " x ", image.rows,
                   " pixels (image_width, image_height: ", image_size_.width, " x ",
                   image_size_.height, ')');
  }
  if (!problem.empty()) problem = "the image " + problem;
  double t = 0.0;
  if (!streams_.accept(kImage, message.header, problem, &t)) return;
  use(pipeline_->addImage(t, image));
}

void FeatureTrackerLinesNode::onImage(const sensor_msgs::Image& message) {
  addImage(message, feature_tracker_lines::decodeImage<sensor_msgs::Image>);
}

void FeatureTrackerLinesNode::onCompressed(const sensor_msgs::CompressedImage& message) {
  addImage(message, feature_tracker_lines::decodeCompressedImage<sensor_msgs::CompressedImage>);
}

// After every message: `status` is what became of it.
void FeatureTrackerLinesNode::use(AddStatus status) {
  if (status == AddStatus::kRestarted) {
    ROS_WARN("time has jumped: all data before it are discarded");
    publishRestart();
  }
  bool worked = true;
  while (worked) {
    const std::optional<TrackedFrame> tracked = pipeline_->track(&worked);
    if (tracked.has_value()) publish(*tracked);
  }
}

void FeatureTrackerLinesNode::publish(const TrackedFrame& tracked) {
  std_msgs::Header header;
  header.stamp = rosTime(streams_.clock().stampNs(tracked.frame.t));
  header.frame_id = kCameraFrame;
  sensor_msgs::PointCloud points, lines;
  points.header = lines.header = header;
  const FrameObservation* previous =
      std::isfinite(tracked.previous.t) ? &tracked.previous : nullptr;
  std::string error;
  if (!vins_adapter::writePointMessage(tracked.frame, previous, &points, &error) ||
      !vins_adapter::writeLineMessage(tracked.frame, &lines, &error)) {
    ROS_WARN_STREAM_THROTTLE(5.0, "a frame is not published: " << error);
    return;
  }
  // Lines first, so that they are there when the points arrive.
  lines_.publish(lines);
  features_.publish(points);
  if (debug_image_.getNumSubscribers() > 0) publishDebugImage(header);
}

void FeatureTrackerLinesNode::publishDebugImage(const std_msgs::Header& header) {
  const cv::Mat picture = pipeline_->frontEnd().debugImage();
  if (picture.empty() || !picture.isContinuous()) return;
  sensor_msgs::Image message;
  message.header = header;
  message.height = static_cast<std::uint32_t>(picture.rows);
  message.width = static_cast<std::uint32_t>(picture.cols);
  message.encoding = "bgr8";
  message.step = static_cast<std::uint32_t>(picture.step);
  message.data.assign(picture.datastart, picture.dataend);
  debug_image_.publish(message);
}

Diagnostics::Statuses FeatureTrackerLinesNode::diagnostics() {
  diagnostic_msgs::DiagnosticStatus streams = streams_.report(pipeline_->streamCounts());
  const double ahead = pipeline_->imageAheadOfImu();
  if (std::abs(ahead) > StreamCheck::kJump && streams_.received(kImu) > 0) {
    raise(diagnostic_msgs::DiagnosticStatus::WARN,
          roundedText(3, "images are ", ahead, " s ahead of the IMU (limit ", StreamCheck::kJump,
                      " s)"),
          &streams);
  }
  addValue("images ahead of the IMU [s]", ahead, &streams);

  diagnostic_msgs::DiagnosticStatus tracking = makeStatus("tracking", "tracking");
  const ImagePipelineCounts& counts = pipeline_->counts();
  const feature_tracker_lines::ImageReport& report = pipeline_->frontEnd().report();
  addValue("images", counts.images, &tracking);
  addValue("images waiting", pipeline_->waiting(), &tracking);
  addValue("images tracked", counts.images_tracked, &tracking);
  addValue("images tracked without IMU", counts.images_without_imu, &tracking);
  addValue("images discarded: queue full", counts.images_overrun, &tracking);
  addValue("images discarded: before the first IMU sample", counts.images_before_imu, &tracking);
  addValue("images discarded: refused by the front end", counts.images_refused, &tracking);
  addValue("frames published", counts.frames_published, &tracking);
  addValue("observations discarded: off axis", counts.observations_sideways, &tracking);
  addValue("time jumps", pipeline_->streamCounts().restarts(), &tracking);
  addValue("points", report.points_tracked + report.points_new, &tracking);
  addValue("lines", report.lines_matched + report.lines_carried + report.lines_new, &tracking);
  addValue("gyroscope used", report.rotation_from_gyro, &tracking);
  addValue("front end [ms]", report.total_ms, &tracking);
  const std::int64_t discarded = counts.images_overrun + counts.images_refused;
  if (discarded > discarded_before_) {
    raise(diagnostic_msgs::DiagnosticStatus::WARN,
          std::to_string(discarded - discarded_before_) + " images discarded", &tracking);
  }
  discarded_before_ = discarded;
  return {streams, tracking};
}

}  // namespace
}  // namespace slim_init::node

int main(int argc, char** argv) {
  using slim_init::node::FeatureTrackerLinesNode;
  return slim_init::node::runNode<FeatureTrackerLinesNode>(argc, argv, "feature_tracker_lines");
}
