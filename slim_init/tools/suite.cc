// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "suite.h"

#include <filesystem>
#include <fstream>
#include <iostream>

#include "case_fingerprint.h"
#include "finished_case.h"
#include "plots.h"
#include "run_case.h"
#include "source_commit.h"
#include "suite_cases.h"
#include "suite_page.h"

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;

constexpr char kDefaultOut[] = "out/suite";
constexpr char kDrawnSequence[] = "V1_01";  // whose path the paper shows

int fail(ExitCode code, const std::string& sentence) {
  std::cerr << "slim_init: " << sentence << "\n";
  return code;
}

/// As the system names it; empty where it does not.
std::string processorName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const std::size_t begin = line.find_first_not_of(" \t", line.find(':') + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return "";
}

/// Runs a case, or goes on with it, or takes it as it is where it is finished.
Failure finishCase(const SuiteCase& entry, const std::string& label, bool* finished_before,
                   CaseResult* result) {
  const fs::path folder = entry.options.out;
  if (std::string error = evaluation::makeReportDirectory(folder.string()); !error.empty()) {
    return {kExitInternal, error};
  }
  const std::string fingerprint = caseFingerprint(entry.options);
  const std::string finished = (folder / "case.json").string();
  evaluation::WindowJournal journal;
  std::string note;
  if (std::string error = journal.open((folder / "windows.journal").string(), fingerprint, &note);
      !error.empty()) {
    return {kExitInternal, error};
  }
  if (!note.empty()) std::cerr << "slim_init: note: " << entry.folder() << ": " << note << "\n";
  *finished_before = readFinishedCase(finished, fingerprint, journal, result);
  if (*finished_before) return {};
  CaseHooks hooks;
  hooks.journal = &journal;
  hooks.label = label;
  hooks.print_notes = false;  // they are in the case's own report
  *result = CaseResult();
  if (Failure failure = runCase(entry.options, hooks, result)) return failure;
  if (std::string error = writeFinishedCase(finished, fingerprint, *result); !error.empty()) {
    return {kExitInternal, error};
  }
  return {};
}

std::string progressLine(const std::string& label, const SuiteResult& result,
                         bool finished_before) {
  const evaluation::ProtocolResult& run = result.run.result;
  std::string line =
      label + result.entry.folder() + ": " + std::to_string(run.counts.windows) + " windows";
  if (finished_before) return line + ", finished before";
  if (run.from_journal > 0) {
    line += ", " + std::to_string(run.from_journal) + " of them solved before";
  }
  return line;
}

/// Errors and times of every group, and the path of one sequence, as in the paper.
void drawPictures(const std::string& out, SuiteReport* report) {
  for (const SuiteGroup& group : report->groups) {
    if (group.ablation) continue;
    std::vector<std::string> folders;
    for (const SuiteResult* result : group.results) folders.push_back(result->entry.options.out);
    std::vector<std::pair<std::string, std::string>> pictures;
    const std::string note = drawTogether(out, group.prefix, folders, group.title, &pictures);
    if (pictures.empty()) report->picture_note = note;
    report->pictures.insert(report->pictures.end(), pictures.begin(), pictures.end());
  }
  for (const SuiteResult& result : report->results) {
    if (result.entry.ablation || result.entry.paper_column != kDrawnSequence) continue;
    // A case that was finished before may have been run without pictures.
    evaluation::RunInfo info = result.run.info;
    if (info.pictures.empty()) drawPlots(result.entry.options.out, &info);
    for (const auto& [file, title] : info.pictures) {
      if (file != "trajectory.png") continue;
      report->pictures.emplace_back(result.entry.folder() + "/" + file,
                                    result.entry.folder() + ": " + title);
    }
  }
}

std::string writeSuite(const std::string& out, const SuiteReport& report) {
  const evaluation::Page page = suitePage(report);
  const fs::path base(out);
  std::string error = evaluation::writeText(base / "suite.md", evaluation::pageMarkdown(page));
  if (error.empty())
    error = evaluation::writeText(base / "report.html", evaluation::pageHtml(page, out));
  if (error.empty()) error = evaluation::writeText(base / "suite.json", suiteJson(report, out));
  return error;
}

}  // namespace

int runSuite(AbOptions options) {
  if (options.given.count("out") == 0) options.out = kDefaultOut;
  if (std::string error = checkSuiteOptions(options); !error.empty()) {
    return fail(kExitBadInput, error);
  }
  Suite suite;
  if (std::string error = listSuiteCases(options, &suite); !error.empty()) {
    return fail(kExitBadInput, error);
  }
  // Whatever is wrong with an option is best known before the first case is run.
  for (SuiteCase& entry : suite.cases) {
    if (const Failure failure = prepareCase(&entry.options)) {
      return fail(failure.code, failure.sentence);
    }
  }
  if (std::string error = evaluation::makeReportDirectory(options.out); !error.empty()) {
    return fail(kExitInternal, "--out: " + error);
  }
  for (const std::string& note : suite.notes) std::cerr << "slim_init: note: " << note << "\n";

  SuiteReport report;
  report.command = options.command;
  report.program = std::string("slim_init ") + SLIM_INIT_VERSION +
                   (sourceCommit().empty() ? "" : ", commit " + sourceCommit());
  report.processor = processorName();
  report.methods = suite.cases.front().options.method_names;
  report.notes = suite.notes;
  ExitCode code = kExitOk;
  for (std::size_t i = 0; i < suite.cases.size(); ++i) {
    const std::string label =
        "[" + std::to_string(i + 1) + "/" + std::to_string(suite.cases.size()) + "] ";
    SuiteResult result;
    result.entry = suite.cases[i];
    bool finished_before = false;
    if (const Failure failure = finishCase(suite.cases[i], label, &finished_before, &result.run)) {
      // The others are worth having, and this one is named in every report.
      report.failed.push_back(result.entry.folder() + ": " + failure.sentence);
      std::cerr << "slim_init: " << report.failed.back() << "\n";
      if (code == kExitOk) code = failure.code;
      continue;
    }
    if (!options.quiet) std::cout << progressLine(label, result, finished_before) << std::endl;
    report.results.push_back(std::move(result));
  }
  if (report.results.empty()) return fail(code, "no case could be run");
  groupResults(&report);
  if (options.plots == "auto") drawPictures(options.out, &report);
  if (std::string error = writeSuite(options.out, report); !error.empty()) {
    return fail(kExitInternal, error);
  }
  if (!options.quiet) {
    const fs::path out(options.out);
    std::cout << suiteText(report) << "\nReport: " << (out / "suite.md").string()
              << "\nPage: " << (out / "report.html").string() << "\n";
  }
  return code;
}

}  // namespace slim_init::tools
