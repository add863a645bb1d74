// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// POV-Ray as a child process: started once for all frames, read frame by frame.
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <thread>

#include "slim_init/simulation/rendering.h"
#include "slim_init/text.h"

namespace slim_init::simulation {
namespace {

namespace fs = std::filesystem;
using feature_tracker_lines::Camera;

constexpr const char* kSceneFile = "scene.pov";
constexpr const char* kLogFile = "povray.log";
constexpr const char* kPicturePrefix = "frame";

void report(const std::string& message, std::string* error) {
  if (error != nullptr) *error = message;
}

// Path of a program: the name itself if it contains a slash, otherwise found along PATH; empty if
// there is none.
std::string findProgram(const std::string& program) {
  if (program.empty()) return "";
  if (program.find('/') != std::string::npos) {
    if (access(program.c_str(), X_OK) != 0) return "";
    std::error_code ignored;
    return fs::absolute(program, ignored).string();
  }
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string candidate = (fs::path(folder.empty() ? "." : folder) / program).string();
    if (access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return "";
}

std::string absentSentence(const std::string& program) {
  return "POV-Ray was not found ('" + program +
         "' is no program on the PATH): install the package povray, or name the program with its "
         "path";
}

// The last lines of a text file, for an error message.
std::string lastLines(const fs::path& file, std::size_t count) {
  std::ifstream in(file);
  std::deque<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    line.erase(std::remove(line.begin(), line.end(), '\r'), line.end());
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    lines.push_back(line);
    if (lines.size() > count) lines.pop_front();
  }
  std::string text;
  for (const std::string& line : lines) text += "\n  " + line;
  return text;
}

}  // namespace

bool povrayAvailable(const std::string& program, std::string* error) {
  if (!findProgram(program).empty()) return true;
  report(absentSentence(program), error);
  return false;
}

namespace {

class PovrayRun : public Renderer {
 public:
  ~PovrayRun() override {
    if (child_ > 0 && !ended_) {
      kill(child_, SIGTERM);
      int status = 0;
      while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
      }
    }
    if (!folder_.empty()) {
      std::error_code ignored;
      fs::remove_all(folder_, ignored);
    }
  }

  std::string start(const Scene& scene, const feature_tracker_lines::CameraParameters& parameters,
                    const std::vector<CameraPose>& poses, const RenderOptions& options) {
    if (std::string s = parameters.validate(); !s.empty()) return "camera: " + s;
    if (poses.empty()) return "there is no pose to render";
    const std::string program = findProgram(options.program);
    if (program.empty()) return absentSentence(options.program);

    const Camera camera(parameters);
    std::string error;
    if (!makeEquidistantView(camera, &view_, &error)) return error;
    makeMap(camera);

    if (std::string s = makeFolder(options.work_directory); !s.empty()) return s;
    {
      std::ofstream file(folder_ / kSceneFile);
      // For a single frame POV-Ray makes no animation and no number in the name.
      std::vector<CameraPose> drawn = poses;
      if (drawn.size() == 1) drawn.push_back(drawn.front());
      drawn_ = drawn.size();
      file << povrayText(scene, view_, drawn);
      if (!file.flush()) return "the scene cannot be written to " + folder_.string();
    }
    frames_ = poses.size();
    digits_ = std::to_string(drawn_).size();
    return spawn(program, options);
  }

  cv::Mat next(std::string* error) override {
    if (done_ == frames_) {
      report("all " + std::to_string(frames_) + " pictures have been taken", error);
      return {};
    }
    // A picture is complete when POV-Ray has begun the next one or has ended.
    const fs::path mine = picture(done_ + 1);
    while (!ended_ && !(done_ + 2 <= drawn_ && fs::exists(picture(done_ + 2)))) {
      int status = 0;
      const pid_t waited = waitpid(child_, &status, WNOHANG);
      if (waited == child_) {
        ended_ = true;
        status_ = status;
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const bool failed = ended_ && !(WIFEXITED(status_) && WEXITSTATUS(status_) == 0);
    cv::Mat drawn;
    if (fs::exists(mine) && !(failed && !fs::exists(picture(done_ + 2)))) {
      drawn = cv::imread(mine.string(), cv::IMREAD_ANYDEPTH | cv::IMREAD_GRAYSCALE);
    }
    if (drawn.empty() || drawn.cols != view_.width || drawn.rows != view_.height) {
      std::string what = "left no readable picture";
      if (failed) {
        what = WIFEXITED(status_)
                   ? text("failed with exit code ", WEXITSTATUS(status_))
                   : text("was ended by signal ", WIFSIGNALED(status_) ? WTERMSIG(status_) : 0);
      }
      report(text("POV-Ray ", what, " at frame ", done_ + 1, " of ", frames_,
                  "; its last lines:", lastLines(folder_ / kLogFile, 8)),
             error);
      return {};
    }
    std::error_code ignored;
    fs::remove(mine, ignored);
    ++done_;

    cv::Mat linear;
    drawn.convertTo(linear, CV_32F, drawn.depth() == CV_16U ? 1.0 / 65535.0 : 1.0 / 255.0);
    cv::Mat radiance;
    // Cubic: linear interpolation would blur by an amount that changes from pixel to pixel.
    cv::remap(linear, radiance, map_x_, map_y_, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    return radiance;
  }

 private:
  void makeMap(const Camera& camera) {
    const auto& parameters = camera.parameters();
    map_x_.create(parameters.height, parameters.width, CV_32FC1);
    map_y_.create(parameters.height, parameters.width, CV_32FC1);
    for (int v = 0; v < parameters.height; ++v) {
      for (int u = 0; u < parameters.width; ++u) {
        const Eigen::Vector2d at = view_.project(camera.bearing({u, v}));
        map_x_.at<float>(v, u) = static_cast<float>(at.x());
        map_y_.at<float>(v, u) = static_cast<float>(at.y());
      }
    }
  }

  std::string makeFolder(const std::string& parent) {
    std::error_code code;
    fs::create_directories(parent, code);
    if (code) return "folder " + parent + " cannot be made: " + code.message();
    std::string name = (fs::path(parent) / "render-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      return "no folder can be made in " + parent + ": " + std::strerror(errno);
    }
    folder_ = name;
    return "";
  }

  fs::path picture(std::size_t number) const {
    std::string text = std::to_string(number);
    text.insert(0, digits_ - std::min(digits_, text.size()), '0');
    return folder_ / (kPicturePrefix + text + ".png");
  }

  std::string spawn(const std::string& program, const RenderOptions& options) {
    std::vector<std::string> arguments = {
        program,
        text("+I", kSceneFile),
        text("+O", kPicturePrefix, ".png"),
        "+FN",
        "Grayscale_Output=on",
        "Bits_Per_Color=16",
        "File_Gamma=1.0",
        "+W" + std::to_string(view_.width),
        "+H" + std::to_string(view_.height),
        "-D",
        "-P",
        "-GS",
        "-GR",
        "-GD",
        "+BM2",  // a tree of solids: faster for the hundreds of a scene
        "+WT" + std::to_string(options.threads),
        "+KI0",
        "+KF1",
        "+KFI1",
        "+KFF" + std::to_string(drawn_),
        // A pixel is the mean of rays through its corners, and divided into four, twice at most, if
        // these differ by 5 % of full brightness. POV-Ray adds up three colours.
        "+AM2",
        "-J",
        "+A0.15",
        "+R2",
    };
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);

    // The child works inside the folder: POV-Ray's file rules allow the current folder.
    const pid_t child = fork();
    if (child < 0) return std::string("no process can be started: ") + std::strerror(errno);
    if (child == 0) {
      // Only functions that are safe between fork and exec. A parent that is killed draws no more.
      prctl(PR_SET_PDEATHSIG, SIGTERM);
      const int log = open((folder_ / kLogFile).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      const int null = open("/dev/null", O_RDONLY);
      if (log < 0 || null < 0 || chdir(folder_.c_str()) != 0) _exit(127);
      dup2(null, STDIN_FILENO);
      dup2(log, STDOUT_FILENO);
      dup2(log, STDERR_FILENO);
      execv(program.c_str(), pointers.data());
      _exit(127);
    }
    child_ = child;
    return "";
  }

  EquidistantView view_;
  cv::Mat map_x_, map_y_;  // position in the view of every pixel of the image
  fs::path folder_;
  std::size_t frames_ = 0;  // requested
  std::size_t drawn_ = 0;   // by POV-Ray
  std::size_t digits_ = 1;  // of the numbers in the names of pictures
  std::size_t done_ = 0;
  pid_t child_ = -1;
  bool ended_ = false;
  int status_ = 0;
};

}  // namespace

std::unique_ptr<Renderer> Renderer::start(const Scene& scene,
                                          const feature_tracker_lines::CameraParameters& camera,
                                          const std::vector<CameraPose>& poses,
                                          const RenderOptions& options, std::string* error) {
  auto renderer = std::make_unique<PovrayRun>();
  if (const std::string message = renderer->start(scene, camera, poses, options);
      !message.empty()) {
    report(message, error);
    return nullptr;
  }
  return renderer;
}

}  // namespace slim_init::simulation
