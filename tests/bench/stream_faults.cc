// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream_faults.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace slim_init::tools {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295;

using Random = std::mt19937_64;

double uniform(Random* random) { return std::uniform_real_distribution<double>(0.0, 1.0)(*random); }
double normal(Random* random) { return std::normal_distribution<double>()(*random); }

// Whether the track is one of the `share` that are afflicted, the same in every image.
bool isChosen(FeatureId id, double share) {
  std::uint64_t x = static_cast<std::uint64_t>(id) * 0x9e3779b97f4a7c15ull;
  x ^= x >> 32;
  return static_cast<double>(x & 0xffff) < share * 65536.0;
}

template <typename Change>
void changeImu(Streams* streams, const Trouble& trouble, const Change& change) {
  for (auto& imu : streams->imu) {
    if (trouble.holds(imu.true_t)) change(&imu.message);
  }
}

template <typename Change>
void changePoints(Streams* streams, const Trouble& trouble, const Change& change) {
  for (auto& frame : streams->frames) {
    if (!trouble.holds(frame.true_t)) continue;
    for (PointObservation& point : frame.message.points) change(frame.true_t, &point);
  }
}

template <typename Message, typename Is>
void removeIf(std::vector<Delivered<Message>>* list, const Is& is) {
  list->erase(std::remove_if(list->begin(), list->end(), is), list->end());
}

// A bearing moved by pixels on the image plane.
Eigen::Vector3d moved(const Eigen::Vector3d& bearing, double x_px, double y_px, double focal_px) {
  const Eigen::Vector3d ray = bearing / bearing.z();
  return (ray + Eigen::Vector3d(x_px, y_px, 0.0) / focal_px).normalized();
}

// ------------------------------------------------------------------------------------------ IMU

void imuGapOf(double seconds, const Trouble& trouble, Streams* streams) {
  removeIf(&streams->imu, [&](const Delivered<ImuSample>& imu) {
    return imu.true_t >= trouble.begin && imu.true_t < trouble.begin + seconds;
  });
}

void shiftImuStamps(const Trouble& trouble, double seconds, Streams* streams) {
  for (auto& imu : streams->imu) {
    if (imu.true_t >= trouble.begin) imu.message.t += seconds;
  }
}

std::vector<StreamFault> imuFaults() {
  return {
      {"imu-spike", "one sample of 1000 m/s^2", false,
       [](const Trouble& trouble, Random*, Streams* streams) {
         for (auto& imu : streams->imu) {
           if (imu.true_t < trouble.begin) continue;
           imu.message.accel.x() += 1000.0;
           return;
         }
       }},
      {"imu-spike-within-limits", "+100 m/s^2 for 25 ms", false,
       [](const Trouble& trouble, Random*, Streams* streams) {
         changeImu(streams, {trouble.begin, trouble.begin + 0.025},
                   [](ImuSample* sample) { sample->accel.x() += 100.0; });
       }},
      {"imu-noise", "noise of 20 m/s^2 and 1 rad/s", false,
       [](const Trouble& trouble, Random* random, Streams* streams) {
         changeImu(streams, trouble, [random](ImuSample* sample) {
           for (int i = 0; i < 3; ++i) {
             sample->accel[i] += 20.0 * normal(random);
             sample->gyro[i] += normal(random);
           }
         });
       }},
      {"imu-stuck", "the sensor repeats one sample", false,
       [](const Trouble& trouble, Random*, Streams* streams) {
         const ImuSample* first = nullptr;
         for (auto& imu : streams->imu) {
           if (!trouble.holds(imu.true_t)) continue;
           if (first == nullptr) first = &imu.message;
           imu.message.accel = first->accel;
           imu.message.gyro = first->gyro;
         }
       }},
      {"imu-saturated", "rates end at 0.5 rad/s, forces at 12 m/s^2", true,
       [](const Trouble& trouble, Random*, Streams* streams) {
         changeImu(streams, trouble, [](ImuSample* sample) {
           sample->gyro = sample->gyro.cwiseMax(-0.5).cwiseMin(0.5);
           sample->accel = sample->accel.cwiseMax(-12.0).cwiseMin(12.0);
         });
       }},
      {"imu-axes-swapped", "x and y exchanged", true,
       [](const Trouble& trouble, Random*, Streams* streams) {
         changeImu(streams, trouble, [](ImuSample* sample) {
           std::swap(sample->gyro.x(), sample->gyro.y());
           std::swap(sample->accel.x(), sample->accel.y());
         });
       }},
      {"imu-scale", "forces times 1.05", true,
       [](const Trouble& trouble, Random*, Streams* streams) {
         changeImu(streams, trouble, [](ImuSample* sample) { sample->accel *= 1.05; });
       }},
      {"imu-gap-150ms", "no samples for 0.15 s", false,
       [](const Trouble& trouble, Random*, Streams* streams) { imuGapOf(0.15, trouble, streams); }},
      {"imu-gap-600ms", "no samples for 0.6 s", false,
       [](const Trouble& trouble, Random*, Streams* streams) { imuGapOf(0.6, trouble, streams); }},
      {"imu-drops", "one sample in ten is missing", true,
       [](const Trouble&, Random* random, Streams* streams) {
         removeIf(&streams->imu,
                  [random](const Delivered<ImuSample>&) { return uniform(random) < 0.1; });
       }},
      {"imu-jitter", "stamps off by 2 ms", true,
       [](const Trouble&, Random* random, Streams* streams) {
         for (auto& imu : streams->imu) imu.message.t += 0.002 * normal(random);
       }},
      {"imu-bursts", "samples arrive 0.2 s at a time", true,
       [](const Trouble&, Random*, Streams* streams) {
         for (auto& imu : streams->imu) imu.arrival = 0.2 * std::ceil(imu.arrival / 0.2);
       }},
      {"imu-clock-200ppm", "the IMU's clock runs away by 200 ppm", true,
       [](const Trouble&, Random*, Streams* streams) {
         const double start = streams->imu.front().true_t;
         for (auto& imu : streams->imu) imu.message.t += 200e-6 * (imu.true_t - start);
       }},
      {"imu-jump-ahead", "stamps of the IMU jump 5 s ahead and stay there", false,
       [](const Trouble& trouble, Random*, Streams* streams) {
         shiftImuStamps(trouble, 5.0, streams);
       }},
      {"imu-jump-back", "stamps of the IMU jump 5 s back and stay there", false,
       [](const Trouble& trouble, Random*, Streams* streams) {
         shiftImuStamps(trouble, -5.0, streams);
       }},
  };
}

// --------------------------------------------------------------------------------------- camera

std::vector<StreamFault> cameraFaults() {
  return {
      {"camera-drops", "every second image is missing", true,
       [](const Trouble&, Random* random, Streams* streams) {
         removeIf(&streams->frames,
                  [random](const Delivered<FrameObservation>&) { return uniform(random) < 0.5; });
       }},
      {"camera-repeats", "one image in five comes twice", true,
       [](const Trouble&, Random* random, Streams* streams) {
         std::vector<Delivered<FrameObservation>> frames;
         for (const auto& frame : streams->frames) {
           frames.push_back(frame);
           if (uniform(random) < 0.2) frames.push_back(frame);
         }
         streams->frames = frames;
       }},
      {"camera-late", "images arrive 0.5 s late", true,
       [](const Trouble&, Random*, Streams* streams) {
         for (auto& frame : streams->frames) frame.arrival += 0.5;
       }},
      {"camera-order", "one image in five arrives after the next", true,
       [](const Trouble&, Random* random, Streams* streams) {
         for (auto& frame : streams->frames) frame.arrival += uniform(random) < 0.2 ? 0.12 : 0.0;
       }},
      {"camera-jitter", "stamps off by 2 ms", true,
       [](const Trouble&, Random* random, Streams* streams) {
         for (auto& frame : streams->frames) frame.message.t += 0.002 * normal(random);
       }},
      {"camera-gone", "no images", false,
       [](const Trouble& trouble, Random*, Streams* streams) {
         removeIf(&streams->frames, [&trouble](const Delivered<FrameObservation>& frame) {
           return trouble.holds(frame.true_t);
         });
       }},
      {"camera-dark", "images with nothing in them; tracks are new afterwards", false,
       [](const Trouble& trouble, Random*, Streams* streams) {
         for (auto& frame : streams->frames) {
           if (trouble.holds(frame.true_t)) frame.message.points.clear();
           if (trouble.holds(frame.true_t)) frame.message.lines.clear();
           if (frame.true_t < trouble.end) continue;
           for (PointObservation& point : frame.message.points) point.id += 1000000;
           for (LineObservation& line : frame.message.lines) line.id += 1000000;
         }
       }},
      {"lens-half-covered", "nothing in the left half", true,
       [](const Trouble&, Random*, Streams* streams) {
         for (auto& frame : streams->frames) {
           auto& points = frame.message.points;
           points.erase(std::remove_if(points.begin(), points.end(),
                                       [](const PointObservation& p) { return p.bearing.x() < 0; }),
                        points.end());
           auto& lines = frame.message.lines;
           lines.erase(std::remove_if(lines.begin(), lines.end(),
                                      [](const LineObservation& l) {
                                        return l.start_bearing.x() < 0 || l.end_bearing.x() < 0;
                                      }),
                       lines.end());
         }
       }},
      {"lens-drops", "one track in ten stands still in the image", true,
       [](const Trouble& trouble, Random*, Streams* streams) {
         changePoints(streams, trouble, [](double, PointObservation* point) {
           if (!isChosen(point->id, 0.1)) return;
           const double angle = static_cast<double>(point->id % 360) * kRadPerDeg;
           point->bearing = Eigen::Vector3d(0.3 * std::cos(angle), 0.3 * std::sin(angle), 1.0);
           point->bearing.normalize();
         });
       }},
      {"vehicle-in-view", "three tracks in ten stand still in the lower part of the image", true,
       [](const Trouble& trouble, Random* random, Streams* streams) {
         // Places all over the lower part, and the noise of a tracker on them.
         const double sigma = 0.3 / streams->calibration.focal_px;
         changePoints(streams, trouble, [random, sigma](double, PointObservation* point) {
           if (!isChosen(point->id, 0.3)) return;
           // One number after the other: compilers differ in the order of arguments.
           const double v = sigma * normal(random), u = sigma * normal(random);
           const double x = static_cast<double>(point->id % 97) / 97.0 - 0.5;
           const double y = 0.2 + 0.2 * static_cast<double>(point->id % 31) / 31.0;
           point->bearing = Eigen::Vector3d(x + u, y + v, 1.0).normalized();
         });
       }},
      {"moving-object", "a third of the tracks moves by 60 px/s besides", true,
       [](const Trouble& trouble, Random*, Streams* streams) {
         const double focal = streams->calibration.focal_px;
         changePoints(streams, trouble, [&trouble, focal](double t, PointObservation* point) {
           if (!isChosen(point->id, 0.33)) return;
           point->bearing = moved(point->bearing, 60.0 * (t - trouble.begin), 0.0, focal);
         });
       }},
  };
}

// -------------------------------------------------------------------------------- tracker, host

std::vector<StreamFault> otherFaults() {
  return {
      {"tracker-wrong-ids", "one track in twenty has another's id", true,
       [](const Trouble&, Random* random, Streams* streams) {
         for (auto& frame : streams->frames) {
           auto& points = frame.message.points;
           for (std::size_t i = 0; i + 1 < points.size(); ++i) {
             if (uniform(random) < 0.05) std::swap(points[i].id, points[i + 1].id);
           }
         }
       }},
      {"tracker-drift", "every track wanders by 3 px/s", true,
       [](const Trouble& trouble, Random*, Streams* streams) {
         const double focal = streams->calibration.focal_px;
         changePoints(streams, trouble, [&trouble, focal](double t, PointObservation* point) {
           const double angle = static_cast<double>(point->id * 137 % 360) * kRadPerDeg;
           const double px = 3.0 * (t - trouble.begin);
           point->bearing =
               moved(point->bearing, px * std::cos(angle), px * std::sin(angle), focal);
         });
       }},
      {"tracker-gross-errors", "one observation in five displaced by 20 px", true,
       [](const Trouble& trouble, Random* random, Streams* streams) {
         const double focal = streams->calibration.focal_px;
         changePoints(streams, trouble, [random, focal](double, PointObservation* point) {
           if (uniform(random) >= 0.2) return;
           const double dy = 20.0 * normal(random), dx = 20.0 * normal(random);
           point->bearing = moved(point->bearing, dx, dy, focal);
         });
       }},
      {"tracker-mixed-lines", "ids of the lines in any order", true,
       [](const Trouble&, Random* random, Streams* streams) {
         for (auto& frame : streams->frames) {
           auto& lines = frame.message.lines;
           std::vector<FeatureId> ids;
           for (const LineObservation& line : lines) ids.push_back(line.id);
           std::shuffle(ids.begin(), ids.end(), *random);
           for (std::size_t i = 0; i < lines.size(); ++i) lines[i].id = ids[i];
         }
       }},
      {"tracker-nan", "one point of every image is not a number", true,
       [](const Trouble&, Random* random, Streams* streams) {
         for (auto& frame : streams->frames) {
           auto& points = frame.message.points;
           if (points.empty()) continue;
           points[(*random)() % points.size()].bearing.x() = kNotComputed;
         }
       }},
      {"tracker-few-points", "twelve points in an image", true,
       [](const Trouble&, Random*, Streams* streams) {
         for (auto& frame : streams->frames) {
           auto& points = frame.message.points;
           std::sort(
               points.begin(), points.end(),
               [](const PointObservation& a, const PointObservation& b) { return a.id < b.id; });
           points.resize(std::min<std::size_t>(points.size(), 12));
         }
       }},
      {"host-td", "td error of 20 ms", true,
       [](const Trouble&, Random*, Streams* streams) { streams->calibration.td += 0.02; }},
      {"host-extrinsic", "extrinsic rotation error of 3 deg", true,
       [](const Trouble&, Random*, Streams* streams) {
         streams->calibration.R_b_c *=
             Eigen::AngleAxisd(3.0 * kRadPerDeg, Eigen::Vector3d(1, 2, -1).normalized())
                 .toRotationMatrix();
       }},
      {"host-lever-arm", "lever arm error of 5 cm", true,
       [](const Trouble&, Random*, Streams* streams) {
         streams->calibration.t_b_c += Eigen::Vector3d(0.03, -0.03, 0.03);
       }},
      {"host-restart", "the host is restarted", false,
       [](const Trouble& trouble, Random*, Streams* streams) { streams->restart = trouble.end; }},
  };
}

}  // namespace

const std::vector<StreamFault>& streamFaults() {
  static const std::vector<StreamFault> faults = [] {
    std::vector<StreamFault> all = {
        {"none", "as recorded", false, [](const Trouble&, Random*, Streams*) {}}};
    for (const auto& group : {imuFaults(), cameraFaults(), otherFaults()}) {
      all.insert(all.end(), group.begin(), group.end());
    }
    return all;
  }();
  return faults;
}

}  // namespace slim_init::tools
