// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "suite_page.h"

#include <algorithm>

namespace slim_init::tools {
namespace {

using evaluation::MethodSummary;
using evaluation::Page;
using evaluation::PageCode;
using evaluation::PageHeading;
using evaluation::PageList;
using evaluation::PageParagraph;
using evaluation::PagePicture;
using evaluation::SubsetOf;
using evaluation::Table;

struct NamedSubset {
  SubsetOf windows;
  const char* name;
};
constexpr NamedSubset kSubsets[] = {{&MethodSummary::excited, "excited windows"},
                                    {&MethodSummary::all, "all windows"}};

constexpr char kPrinted[] =
    "In brackets: what the paper printed for the sequence of that name, from its images, with the "
    "authors' programs; its own method stands beside `slim-paper`.";
constexpr char kPrintedSimulated[] =
    " Motion and IMU data here are EuRoC's, the features are simulated along the true path: the "
    "same motion, not the same tracks.";
constexpr char kDagger[] =
    " A dagger: over fewer than half of the windows, which are the easier ones.";

Table titled(const std::string& title, Table table) {
  table.title = title;
  return table;
}

/// The groups of the paper's EuRoC tables: real motion.
bool isReal(const SuiteGroup& group) { return !group.ablation && group.kind != CaseKind::kBuiltin; }

const SuiteGroup* firstReal(const SuiteReport& report) {
  const auto found = std::find_if(report.groups.begin(), report.groups.end(), isReal);
  return found == report.groups.end() ? nullptr : &*found;
}

/// Fig. 6 is about EuRoC; without it about whatever was run.
SuiteResults timedResults(const SuiteReport& report) {
  if (const SuiteGroup* real = firstReal(report)) return real->results;
  SuiteResults all;
  for (const SuiteGroup& group : report.groups) {
    if (!group.ablation) all.insert(all.end(), group.results.begin(), group.results.end());
  }
  return all;
}

/// Cases in which there is something to succeed at.
SuiteResults withScale(const SuiteReport& report) {
  SuiteResults results;
  for (const SuiteGroup& group : report.groups) {
    if (group.ablation) continue;
    std::copy_if(group.results.begin(), group.results.end(), std::back_inserter(results),
                 [](const SuiteResult* result) { return !result->entry.withoutParallax(); });
  }
  return results;
}

bool hasMethod(const SuiteReport& report, const std::string& name) {
  return std::find(report.methods.begin(), report.methods.end(), name) != report.methods.end();
}

void addRun(const SuiteReport& report, Page* page) {
  page->add(PageHeading{"What was run"});
  page->add(PageCode{report.command});
  SuiteResults all;
  for (const SuiteResult& result : report.results) all.push_back(&result);
  page->add(PageParagraph{report.program +
                          (report.processor.empty() ? "" : ", " + report.processor) +
                          ". Every case has a folder of that name with its own report, the options "
                          "and the command that runs it alone."});
  page->add(caseTable(all));
  std::vector<std::string> items = report.notes;
  for (const std::string& sentence : report.failed) items.push_back("NOT RUN: " + sentence);
  for (const SuiteResult& result : report.results) {
    if (result.run.result.has_truth) continue;
    items.push_back(result.entry.folder() + ": no ground truth, so no errors and no success");
  }
  if (!items.empty()) page->add(PageList{items});
}

void addAccuracy(const SuiteReport& report, Page* page) {
  for (const SuiteGroup& group : report.groups) {
    if (!isReal(group)) continue;
    page->add(PageHeading{"Table I, accuracy: " + group.title});
    page->add(PageParagraph{std::string(kPrinted) +
                            (group.kind == CaseKind::kRecorded ? kPrintedSimulated : "") +
                            kDagger});
    for (const NamedSubset& subset : kSubsets) {
      for (const Table& table : accuracyTables(group.results, subset.windows)) {
        page->add(titled(table.title + ", " + subset.name, table));
      }
    }
  }
}

void addDetails(const SuiteReport& report, Page* page) {
  page->add(PageHeading{"Accuracy per sequence, with median and 90 % quantile"});
  for (const SuiteGroup& group : report.groups) {
    if (group.ablation) continue;
    for (const NamedSubset& subset : kSubsets) {
      // Slow motion is what the excitation gate leaves out.
      if (group.degenerate && subset.windows == &MethodSummary::excited) continue;
      page->add(
          titled(group.title + ", " + subset.name, detailTable(group.results, subset.windows)));
    }
  }
}

void addSuccess(const SuiteReport& report, Page* page) {
  for (const SuiteGroup& group : report.groups) {
    if (!isReal(group)) continue;
    page->add(PageHeading{"Table II, success rate: " + group.title});
    page->add(PageParagraph{
        std::string(kPrinted) +
        " The printed rates are over all sequences of the group; ours over those in the brackets "
        "of the column's title." +
        (group.kind == CaseKind::kRecorded ? kPrintedSimulated : "")});
    for (const NamedSubset& subset : kSubsets) {
      page->add(titled(std::string("Success [%], ") + subset.name,
                       successTable(group.results, subset.windows)));
    }
  }
}

void addDegenerate(const SuiteReport& report, Page* page) {
  for (const SuiteGroup& group : report.groups) {
    if (!group.degenerate || group.ablation) continue;
    page->add(PageHeading{"Table III, degenerate motion (all windows)"});
    page->add(PageParagraph{
        "Beside the corridor walk stands what the paper printed as the average of its own three "
        "walks, C_01 to C_03: the same kind of motion, not the same data, which are not public. On "
        "hover and pure rotation there is no scale to be seen: what counts there is that nothing "
        "is accepted." +
        std::string(kDagger)});
    page->add(degenerateTable(group.results));
  }
}

void addAblation(const SuiteReport& report, Page* page) {
  for (const SuiteGroup& group : report.groups) {
    if (!group.ablation) continue;
    page->add(
        PageHeading{(group.degenerate ? "Table IV, ablation: " : "Ablation: ") + group.title});
    std::string names;
    for (const SuiteResult* result : group.results) {
      names += (names.empty() ? "" : ", ") + result->entry.name;
    }
    page->add(PageParagraph{
        "All windows of " + names + " together. In brackets the paper's: " +
        (group.degenerate ? "the average of its own walks C_01 to C_03, again the same kind of "
                            "motion and not the same data."
                          : "the mean gyroscope bias error on EuRoC, there over its eleven "
                            "sequences and from images.") +
        kDagger});
    page->add(ablationTable(group.results, group.degenerate));
  }
}

void addTimes(const SuiteReport& report, Page* page) {
  page->add(PageHeading{"Fig. 6, solve time"});
  page->add(PageParagraph{
      "CPU time of the solving thread over the windows with an estimate, of " +
      std::string(firstReal(report) != nullptr ? firstReal(report)->title : "all cases") +
      ". In brackets the mean that the paper printed for EuRoC, on an Intel Core i9-12900K: "
      "compare "
      "the ratios, not the milliseconds. Wall times mean something with --threads 1 on an idle "
      "machine only."});
  page->add(timeTable(timedResults(report)));
}

void addDifferences(const SuiteReport& report, Page* page) {
  if (!hasMethod(report, kReference) || report.methods.size() < 2) return;
  page->add(PageHeading{std::string("Differences to ") + kReference});
  page->add(PageParagraph{
      std::string("Every method minus `") + kReference +
      "`, window by window, with 95 % intervals (block bootstrap: windows overlap, so neighbours "
      "are drawn together). Success over all windows: a negative number is fewer. Errors over the "
      "windows in which both succeed: a positive number is worse. Bold: zero is outside the "
      "interval. All windows."});
  for (const SuiteGroup& group : report.groups) {
    if (group.ablation) continue;
    page->add(titled(group.title, differenceTable(group.comparisons, kReference)));
  }
}

/// Says where the reference is not the best, so that nobody has to look for it.
void addNotFirst(const SuiteReport& report, Page* page) {
  if (!hasMethod(report, kReference) || report.methods.size() < 2) return;
  page->add(PageHeading{std::string("Where ") + kReference + " is not first"});
  for (const NamedSubset& subset : kSubsets) {
    int figures = 0;
    const Table table =
        notFirstTable(detailTable(withScale(report), subset.windows), kReference, &figures);
    const int not_first = static_cast<int>(table.rows.size());
    page->add(PageParagraph{std::string("Success and errors of every sequence but those without "
                                        "parallax, ") +
                            subset.name + ": `" + kReference + "` is first or level in " +
                            std::to_string(figures - not_first) + " of " + std::to_string(figures) +
                            " columns."});
    if (not_first > 0) page->add(table);
  }
}

void addVerdicts(const SuiteReport& report, Page* page) {
  page->add(PageHeading{"Verdicts (all windows)"});
  page->add(PageParagraph{
      "Where every window went: accepted, waiting, refused and failed sum up to all of them. The "
      "published methods have no checks of their own and accept what they compute."});
  for (const SuiteGroup& group : report.groups) {
    if (group.ablation) continue;
    page->add(titled(group.title, caseMethodTable(group.results, evaluation::verdictColumns(),
                                                  &MethodSummary::all)));
  }
}

void addDownstream(const SuiteReport& report, Page* page) {
  const bool any = std::any_of(report.results.begin(), report.results.end(),
                               [](const SuiteResult& r) { return r.run.result.has_downstream; });
  if (!any) return;
  page->add(PageHeading{"What an estimator makes of the accepted answers"});
  page->add(PageParagraph{
      "The same sliding-window back end started from every accepted answer and run on the same "
      "tracks; a method that accepts more starts it more often, from harder windows too. All "
      "windows."});
  for (const SuiteGroup& group : report.groups) {
    if (group.ablation) continue;
    page->add(titled(group.title, caseMethodTable(group.results, evaluation::downstreamColumns(),
                                                  &MethodSummary::all)));
  }
}

void addPictures(const SuiteReport& report, Page* page) {
  if (report.pictures.empty() && report.picture_note.empty()) return;
  page->add(PageHeading{"Pictures"});
  if (report.pictures.empty()) page->add(PageParagraph{report.picture_note});
  for (const auto& [file, title] : report.pictures) page->add(PagePicture{file, title});
}

SuiteGroup makeGroup(const std::string& title, const std::string& prefix,
                     const std::vector<SuiteResult>& results,
                     bool (*belongs)(const SuiteCase& entry), bool ablation) {
  SuiteGroup group;
  group.title = title;
  group.prefix = prefix;
  group.ablation = ablation;
  for (const SuiteResult& result : results) {
    if (result.entry.ablation != ablation || !belongs(result.entry)) continue;
    group.results.push_back(&result);
    group.kind = result.entry.kind;
    group.degenerate = result.entry.degenerate() || result.entry.withoutParallax();
  }
  return group;
}

}  // namespace

void groupResults(SuiteReport* report) {
  struct Kind {
    const char* title;
    const char* prefix;
    bool (*belongs)(const SuiteCase& entry);
  };
  static constexpr Kind kKinds[] = {
      {"EuRoC, from images", "images_",
       [](const SuiteCase& entry) { return entry.kind == CaseKind::kImages; }},
      {"recorded motion and IMU, simulated features", "recorded_",
       [](const SuiteCase& entry) { return entry.kind == CaseKind::kRecorded; }},
      {"degenerate motion, simulated", "degenerate_",
       [](const SuiteCase& entry) { return entry.degenerate() || entry.withoutParallax(); }},
      {"excited motion, simulated", "excited_", [](const SuiteCase& entry) {
         return entry.kind == CaseKind::kBuiltin && !entry.degenerate() && !entry.withoutParallax();
       }}};
  report->groups.clear();
  for (const bool ablation : {false, true}) {
    for (const Kind& kind : kKinds) {
      SuiteGroup group =
          makeGroup(kind.title, kind.prefix, report->results, kind.belongs, ablation);
      if (group.results.empty()) continue;
      if (!ablation) {
        group.comparisons = evaluation::compareWith(kReference, protocolResults(group.results),
                                                    evaluation::WindowSubset::kAll);
      }
      report->groups.push_back(std::move(group));
    }
  }
}

Page suitePage(const SuiteReport& report) {
  Page page;
  page.title = "The paper's tables";
  addRun(report, &page);
  addAccuracy(report, &page);
  addSuccess(report, &page);
  addDegenerate(report, &page);
  addAblation(report, &page);
  addTimes(report, &page);
  addDifferences(report, &page);
  addNotFirst(report, &page);
  addDetails(report, &page);
  addVerdicts(report, &page);
  addDownstream(report, &page);
  addPictures(report, &page);
  page.add(PageHeading{"How to read this"});
  page.add(PageParagraph{evaluation::howToRead()});
  return page;
}

std::string suiteText(const SuiteReport& report) {
  std::string text;
  const auto add = [&text](const std::string& title, Table table) {
    text += "\n" + tableText(titled(title, std::move(table)));
  };
  for (const SuiteGroup& group : report.groups) {
    if (!isReal(group)) continue;
    for (const Table& table : accuracyTables(group.results, &MethodSummary::excited)) {
      add("Table I, " + group.title + ", excited windows: " + table.title, table);
    }
    for (const NamedSubset& subset : kSubsets) {
      add("Table II, " + group.title + ", " + subset.name + ": success [%]",
          successTable(group.results, subset.windows));
    }
  }
  for (const SuiteGroup& group : report.groups) {
    if (group.degenerate && !group.ablation) {
      add("Table III, degenerate motion, all windows", degenerateTable(group.results));
    }
    if (group.degenerate && group.ablation) {
      add("Table IV, ablation, all windows", ablationTable(group.results, true));
    }
  }
  add("Fig. 6, solve time", timeTable(timedResults(report)));
  if (hasMethod(report, kReference) && report.methods.size() > 1) {
    for (const SuiteGroup& group : report.groups) {
      if (group.ablation) continue;
      add("Difference with 95 % interval, " + group.title + ", all windows",
          differenceTable(group.comparisons, kReference));
    }
  }
  return text +
         "\nIn brackets: printed in the paper. *: best of its column, or zero outside the "
         "interval. \xE2\x80\xA0: over fewer than half of the windows.\n";
}

}  // namespace slim_init::tools
