// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <exception>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "datasets/csv_table.h"
#include "slim_init/evaluation/image_sequence.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

class AslFolder : public ImageSequence {
 public:
  void open(const std::string& directory, double max_imu_gap_s) {
    findRoot(directory);
    readImu(file("imu0/data.csv"), max_imu_gap_s, this);
    readSpeeds(file("speed0/data.csv"), this);
    readImages();
    const std::string truth_file = file("state_groundtruth_estimate0/data.csv");
    if (std::error_code code; fs::exists(truth_file, code)) readTruth(truth_file, this);
  }

  cv::Mat image(std::size_t k, std::string* sentence) override {
    const std::string& path = image_files_[k];
    // Asked first, because OpenCV prints to the console about a file it cannot open.
    std::error_code code;
    std::string reason = "is gone";
    if (fs::is_regular_file(path, code)) {
      reason = "cannot be decoded";
      try {
        cv::Mat read = cv::imread(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
        if (!read.empty()) return read;
      } catch (const std::exception&) {
      }
    }
    if (sentence != nullptr) *sentence = path + " " + reason;
    return cv::Mat();
  }

 private:
  std::string file(const char* part) const { return (fs::path(root_) / part).string(); }

  void findRoot(const std::string& directory) {
    std::error_code code;
    if (!fs::is_directory(directory, code)) fail(directory, " is not a directory");
    const fs::path given(directory);
    for (const fs::path& candidate : {given / "mav0", given}) {
      if (!fs::is_directory(candidate / "cam0", code)) continue;
      if (!fs::is_directory(candidate / "imu0", code)) continue;
      root_ = candidate.string();
      name = lastComponent(directory);
      // "V1_01/mav0" is V1_01.
      if (name == "mav0") name = lastComponent((given / "..").string());
      return;
    }
    fail(directory, " is not an ASL folder: neither it nor its mav0 holds cam0 and imu0");
  }

  void readImages() {
    const CsvTable table = readTable(file("cam0/data.csv"), imageFormat(1), &notes);
    image_disorder = table.disorder;
    const fs::path folder = fs::path(root_) / "cam0" / "data";
    std::string first_missing;
    std::error_code code;
    for (const CsvRow& row : table.rows) {
      const fs::path path =
          folder / (row.text.empty() ? std::to_string(row.stamp_ns) + ".png" : row.text);
      if (!fs::is_regular_file(path, code)) {
        if (image_disorder.unreadable++ == 0) first_missing = path.string();
        continue;
      }
      image_times.push_back(relativeSeconds(row.stamp_ns, t0_ns));
      image_files_.push_back(path.string());
    }
    if (image_disorder.unreadable > 0) {
      notes.push_back(text(image_disorder.unreadable, " of ", table.rows.size(), " images of ",
                           table.path, " have no file, the first is ", first_missing));
    }
    if (images() < kMinImages) {
      fail(table.path, " names ", images(), " images that exist (minimum ", kMinImages, ')',
           first_missing.empty() ? "" : "; " + first_missing + " does not exist");
    }
  }

  std::string root_;  ///< the folder that holds cam0 and imu0
  std::vector<std::string> image_files_;
};

}  // namespace

std::unique_ptr<ImageSequence> openAslFolder(const std::string& directory, double max_imu_gap_s,
                                             ReadStatus* status) {
  auto folder = std::make_unique<AslFolder>();
  *status = statusOf([&] { folder->open(directory, max_imu_gap_s); });
  if (!status->ok()) return nullptr;
  return folder;
}

}  // namespace slim_init::evaluation
