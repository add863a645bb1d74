// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The report of one sequence as a page.
#include <algorithm>
#include <cmath>
#include <set>

#include "slim_init/evaluation/method_tables.h"
#include "slim_init/evaluation/page.h"
#include "slim_init/evaluation/report.h"
#include "slim_init/evaluation/statistics.h"

namespace slim_init::evaluation {
namespace {

struct NamedSubset {
  SubsetOf windows;
  const char* name;
};
constexpr NamedSubset kSubsets[] = {{&MethodSummary::excited, "Excited windows"},
                                    {&MethodSummary::all, "All windows"}};

int windowsOf(const std::vector<MethodSummary>& summaries, SubsetOf subset) {
  return summaries.empty() ? 0 : (summaries.front().*subset).windows;
}

std::string plural(int count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string numberText(const char* pattern, double value) {
  return numberCell(pattern, value).text;
}

std::string optionText(const OptionValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&value)) return numberText("%g", *number);
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  std::string joined;
  for (const std::string& item : std::get<std::vector<std::string>>(value)) {
    joined += (joined.empty() ? "" : ", ") + item;
  }
  return joined;
}

Table optionTable(const RunInfo& info) {
  Table table;
  table.columns = {"option", "value"};
  table.text_columns = 2;
  for (const auto& [key, value] : info.options) table.rows.push_back({key, optionText(value)});
  table.rows.push_back({"true gyro bias", info.gyro_bias_truth});
  table.rows.push_back({"program", "slim_init " + info.version +
                                       (info.commit.empty() ? "" : ", commit " + info.commit)});
  return table;
}

std::string trialsText(const ProtocolResult& result) {
  const ProtocolCounts& counts = result.counts;
  const auto excited =
      std::count_if(result.windows.begin(), result.windows.end(),
                    [](const WindowRecord& window) { return window.excitation.excited; });
  return plural(counts.trials, "trial") + " over " + plural(counts.frames, "frame") + " gave " +
         plural(counts.windows, "window") + ", " + std::to_string(excited) +
         " of them excited. Not evaluated: " + std::to_string(counts.ended) +
         " (data end before the window is full), " + std::to_string(counts.interrupted) +
         " (interrupted by a gap), " + std::to_string(counts.repeated) +
         " (same keyframes as the window before), " + std::to_string(counts.without_truth) +
         " (no truth at a keyframe), " + std::to_string(counts.invalid) + " (data refused" +
         (result.first_refusal.empty() ? "" : ", first: " + markdownText(result.first_refusal)) +
         ").";
}

std::string droppedText(const StreamCounts& dropped) {
  return "Dropped on the way, over all trials: " + std::to_string(dropped.imu_not_finite) +
         " IMU samples not finite, " + std::to_string(dropped.imu_out_of_order) +
         " out of order; " + std::to_string(dropped.frames_not_finite) + " frames not finite, " +
         std::to_string(dropped.frames_out_of_order) + " out of order; " +
         std::to_string(dropped.observations_not_finite) + " observations not finite, " +
         std::to_string(dropped.observations_duplicate_id) + " with a repeated id, " +
         std::to_string(dropped.lines_degenerate) + " lines without length.";
}

void addRun(const RunInfo& info, const ProtocolResult& result, Page* page) {
  page->add(PageHeading{"What was run"});
  page->add(PageCode{info.command});
  page->add(optionTable(info));
  page->add(PageParagraph{trialsText(result)});
  page->add(PageParagraph{droppedText(result.dropped)});
  if (info.notes.empty()) return;
  page->add(PageParagraph{"Notes on the data:"});
  page->add(PageList{info.notes});
}

void addVariants(const RunInfo& info, Page* page) {
  if (info.method_notes.empty()) return;
  page->add(PageParagraph{"Variants:"});
  PageList list;
  for (const auto& [name, sentence] : info.method_notes) {
    list.items.push_back("`" + name + "`: " + sentence);
  }
  page->add(list);
}

/// The same columns over both sets of windows.
void addBothSubsets(const SummaryColumns& columns, const ProtocolResult& result,
                    const std::vector<MethodSummary>& summaries, Page* page) {
  for (const NamedSubset& subset : kSubsets) {
    page->add(PageParagraph{std::string(subset.name) + ":"});
    page->add(methodTable(columns, summaries, subset.windows, result.has_truth));
  }
}

void addAccepted(const ProtocolResult& result, const std::vector<MethodSummary>& summaries,
                 Page* page) {
  if (result.first_keyframes > 0) {
    const std::string first = std::to_string(result.first_keyframes);
    page->add(PageHeading{"Accepted answers, windows growing from " + first + " keyframes"});
    page->add(PageParagraph{
        "Every trial hands a method a window of " + first +
        " keyframes, then one with a keyframe more, and so on until it accepts; what it says then "
        "counts, in the tables above too. Time to accept is the data from the first to the last "
        "keyframe of that window."});
  } else {
    page->add(PageHeading{"Accepted answers"});
  }
  addBothSubsets(acceptedColumns(), result, summaries, page);
}

void addDownstream(const ProtocolResult& result, const std::vector<MethodSummary>& summaries,
                   Page* page) {
  if (!result.has_downstream) return;
  page->add(PageHeading{"What an estimator makes of the accepted answers"});
  page->add(PageParagraph{
      "The same sliding-window back end was started from every accepted answer and ran on the same "
      "tracks. Final scale error is that of its last window."});
  addBothSubsets(downstreamColumns(), result, summaries, page);
}

void addPictures(const RunInfo& info, Page* page) {
  if (info.pictures.empty() && info.picture_note.empty()) return;
  page->add(PageHeading{"Pictures"});
  if (info.pictures.empty()) page->add(PageParagraph{info.picture_note});
  for (const auto& [file, title] : info.pictures) page->add(PagePicture{file, title});
}

void addStatuses(const std::vector<MethodSummary>& summaries, Page* page) {
  std::set<std::string> names;
  for (const MethodSummary& summary : summaries) {
    for (const auto& status : summary.all.statuses) names.insert(status.first);
  }
  Table table;
  table.columns = {"method", "windows", "with estimate"};
  table.columns.insert(table.columns.end(), names.begin(), names.end());
  for (const MethodSummary& summary : summaries) {
    table.rows.push_back(
        {summary.name, countCell(summary.all.windows), countCell(summary.all.attempted)});
    for (const std::string& name : names) {
      const auto found = summary.all.statuses.find(name);
      table.rows.back().push_back(
          countCell(found == summary.all.statuses.end() ? 0 : found->second));
    }
  }
  page->add(PageHeading{"Verdicts (all windows)"});
  page->add(table);
}

/// What was known where no trajectory was.
void addPartial(const std::vector<MethodSummary>& summaries, Page* page) {
  Table table;
  table.columns = {"method",  "status",
                   "windows", "gravity deg, median",
                   "max",     "gyro bias %, median",
                   "max",     "gyro bias rad/s, rms"};
  table.text_columns = 2;
  for (const MethodSummary& summary : summaries) {
    for (const auto& [status, partial] : summary.all.partial) {
      table.rows.push_back({summary.name, status, countCell(partial.windows),
                            numberCell("%.3f", partial.gravity_median_deg),
                            numberCell("%.3f", partial.gravity_max_deg),
                            numberCell("%.2f", partial.gyro_bias_median_pct),
                            numberCell("%.2f", partial.gyro_bias_max_pct),
                            numberCell("%.5f", partial.gyro_bias_vec_rmse)});
    }
  }
  if (table.rows.empty()) return;
  page->add(PageHeading{"Answers without a trajectory"});
  page->add(
      PageParagraph{"Gravity and gyroscope bias of windows in which nothing more is observable."});
  page->add(table);
}

void addTracking(const TrackingSummary& tracking, Page* page) {
  page->add(PageHeading{"Features from images"});
  page->add(PageParagraph{
      std::to_string(tracking.tracked) + " of " + plural(tracking.images, "image") + " tracked; " +
      std::to_string(tracking.outside_imu) + " outside the IMU data, " +
      std::to_string(tracking.unreadable) + " unreadable, " + std::to_string(tracking.refused) +
      " refused, " + std::to_string(tracking.images_without_gyro) +
      " tracked without the gyro's rotation. A vanishing point was found in " +
      std::to_string(tracking.images_with_vp) + "." +
      (tracking.line_detector.empty() ? "" : " Line detector: " + tracking.line_detector + ".")});
  Table table;
  table.columns = {"a frame", "median", "10 % quantile", "of them from the frame before, median"};
  table.rows = {
      {"points", numberCell("%.0f", tracking.points), numberCell("%.0f", tracking.points_p10),
       numberCell("%.0f", tracking.points_carried)},
      {"lines", numberCell("%.0f", tracking.lines), numberCell("%.0f", tracking.lines_p10),
       numberCell("%.0f", tracking.lines_carried)}};
  page->add(table);
  std::string times = "Front end, one image [ms]: median " +
                      numberText("%.2f", tracking.total_ms_median) + ", 90 % quantile " +
                      numberText("%.2f", tracking.total_ms_p90) + "; median per stage:";
  const char* separator = " ";
  for (const StageTime& stage : tracking.stages_ms_median) {
    times += separator + stage.name + " " + numberText("%.2f", stage.ms);
    separator = ", ";
  }
  page->add(PageParagraph{times + "."});
}

void addSimulated(const std::vector<NamedCount>& simulated, Page* page) {
  if (simulated.empty()) return;
  std::string text;
  for (const auto& [name, count] : simulated) {
    text += (text.empty() ? "" : ", ") + name + " " + std::to_string(count);
  }
  page->add(PageHeading{"Simulated features"});
  page->add(PageParagraph{text + "."});
}

/// "`slim`, median per stage [ms]: ..", in the order in which the stages first occur; empty for a
/// method without stages.
std::string stagesText(const ProtocolResult& result, std::size_t method) {
  std::vector<std::pair<std::string, std::vector<double>>> stages;
  for (const WindowRecord& window : result.windows) {
    if (!window.methods[method].attempted) continue;
    for (const StageTime& stage : window.methods[method].stages) {
      auto found = std::find_if(stages.begin(), stages.end(),
                                [&](const auto& known) { return known.first == stage.name; });
      if (found == stages.end()) found = stages.insert(stages.end(), {stage.name, {}});
      if (std::isfinite(stage.ms)) found->second.push_back(stage.ms);
    }
  }
  std::string text;
  for (const auto& [name, times] : stages) {
    text += (text.empty() ? " " : ", ") + name + " " + numberText("%.3f", median(times));
  }
  return text.empty() ? "" : "`" + result.methods[method] + "`, median per stage [ms wall]:" + text;
}

void addTimes(const ProtocolResult& result, const std::vector<MethodSummary>& summaries,
              Page* page) {
  page->add(PageHeading{"Time per solve, windows with an estimate"});
  page->add(methodTable(timeColumns(), summaries, &MethodSummary::all, result.has_truth));
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    if (const std::string text = stagesText(result, m); !text.empty()) {
      page->add(PageParagraph{text});
    }
  }
}

}  // namespace

Page reportPage(const RunInfo& info, const ProtocolResult& result,
                const std::vector<MethodSummary>& summaries) {
  Page page;
  page.title = "A/B initialization on " + info.dataset;
  addRun(info, result, &page);
  for (const NamedSubset& subset : kSubsets) {
    page.add(PageHeading{std::string(subset.name) + " (" +
                         std::to_string(windowsOf(summaries, subset.windows)) + ")"});
    page.add(methodTable(accuracyColumns(), summaries, subset.windows, result.has_truth));
  }
  if (!result.has_truth) {
    page.add(PageParagraph{
        "There is no ground truth, so no error was computed: the tables tell what the methods "
        "said."});
  }
  addVariants(info, &page);
  addAccepted(result, summaries, &page);
  addDownstream(result, summaries, &page);
  addPictures(info, &page);
  addStatuses(summaries, &page);
  addPartial(summaries, &page);
  if (info.tracking.has_value()) addTracking(*info.tracking, &page);
  addSimulated(info.simulated, &page);
  addTimes(result, summaries, &page);
  page.add(PageHeading{"How to read this"});
  page.add(PageParagraph{howToRead()});
  return page;
}

std::string howToRead() {
  return "Every method saw the same windows, byte for byte. With s the scale of the Sim(3) "
         "alignment of the estimated positions to the truth, a window is a success when the method "
         "returned an estimate with |s - 1| < 0.5, whatever its own verdict; the success rate is "
         "taken over all windows of the table, those without an estimate included. Scale, gravity, "
         "speed, velocity, pose and gyro bias are root mean squares over successful windows only "
         "(the protocol of the paper), so a method with a low success rate is measured on its "
         "easier windows: read the success rate first, and the median and the 90 % quantile (p90) "
         "beside the root mean square. \"Excited\" leaves out windows in which the accelerometer "
         "shows hardly more than gravity, where scale is not observable. \"Accepted\" counts the "
         "windows that the method itself called a success, which is all a user sees in flight, and "
         "the share of those within 10 % of the true scale. The best figure of a column is bold. "
         "Times are CPU times unless they say otherwise. A dash is a number that does not exist. "
         "Definitions: docs/evaluation.md; one row per window and method, with message and gate "
         "values: windows.csv.";
}

std::string reportMarkdown(const RunInfo& info, const ProtocolResult& result,
                           const std::vector<MethodSummary>& summaries) {
  return pageMarkdown(reportPage(info, result, summaries));
}

std::string summaryTable(const ProtocolResult& result,
                         const std::vector<MethodSummary>& summaries) {
  std::string text;
  for (const NamedSubset& subset : kSubsets) {
    const bool excited = subset.windows == &MethodSummary::excited;
    const int windows = windowsOf(summaries, subset.windows);
    text += (excited ? "" : "\n") + plural(windows, excited ? "excited window" : "window") +
            (excited ? "" : " in all") + "\n";
    if (windows == 0) continue;
    text += tableText(methodTable(accuracyColumns(), summaries, subset.windows, result.has_truth));
  }
  if (result.has_downstream) {
    text += "\nBack end from the accepted answers, all windows\n" +
            tableText(
                methodTable(downstreamColumns(), summaries, &MethodSummary::all, result.has_truth));
  }
  text += "\nVerdicts, all windows\n";
  std::size_t width = 0;
  for (const MethodSummary& summary : summaries) width = std::max(width, summary.name.size());
  for (const MethodSummary& summary : summaries) {
    text += "  " + summary.name + std::string(width - summary.name.size() + 2, ' ');
    const char* separator = "";
    for (const auto& [status, count] : summary.all.statuses) {
      text += separator + status + " " + std::to_string(count);
      separator = ", ";
    }
    text += "\n";
  }
  return text;
}

}  // namespace slim_init::evaluation
