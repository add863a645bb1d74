// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "finished_case.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using TextPairs = std::vector<std::pair<std::string, std::string>>;

/// Names and fields of the counts, for both directions.
struct CountField {
  const char* key;
  int evaluation::ProtocolCounts::*field;
};
constexpr CountField kCounts[] = {{"frames", &evaluation::ProtocolCounts::frames},
                                  {"trials", &evaluation::ProtocolCounts::trials},
                                  {"windows", &evaluation::ProtocolCounts::windows},
                                  {"without_truth", &evaluation::ProtocolCounts::without_truth},
                                  {"ended", &evaluation::ProtocolCounts::ended},
                                  {"interrupted", &evaluation::ProtocolCounts::interrupted},
                                  {"repeated", &evaluation::ProtocolCounts::repeated},
                                  {"invalid", &evaluation::ProtocolCounts::invalid}};

Json toJson(const CaseResult& run) {
  Json json = {{"dataset", run.info.dataset},
               {"gyro_bias_truth", run.info.gyro_bias_truth},
               {"notes", run.info.notes},
               {"method_notes", run.info.method_notes},
               {"pictures", run.info.pictures},
               {"methods", run.result.methods},
               {"has_truth", run.result.has_truth},
               {"has_downstream", run.result.has_downstream},
               {"first_refusal", run.result.first_refusal}};
  for (const CountField& count : kCounts)
    json["counts"][count.key] = run.result.counts.*count.field;
  return json;
}

void fromJson(const Json& json, CaseResult* run) {
  run->info.dataset = json.at("dataset").get<std::string>();
  run->info.gyro_bias_truth = json.at("gyro_bias_truth").get<std::string>();
  run->info.notes = json.at("notes").get<std::vector<std::string>>();
  run->info.method_notes = json.at("method_notes").get<TextPairs>();
  run->info.pictures = json.at("pictures").get<TextPairs>();
  run->result.methods = json.at("methods").get<std::vector<std::string>>();
  run->result.has_truth = json.at("has_truth").get<bool>();
  run->result.has_downstream = json.at("has_downstream").get<bool>();
  run->result.first_refusal = json.at("first_refusal").get<std::string>();
  for (const CountField& count : kCounts) {
    run->result.counts.*count.field = json.at("counts").at(count.key).get<int>();
  }
}

}  // namespace

std::string writeFinishedCase(const std::string& file, const std::string& fingerprint,
                              const CaseResult& result) {
  Json json = toJson(result);
  json["fingerprint"] = fingerprint;
  const std::string draft = file + ".new";
  {
    std::ofstream out(draft, std::ios::binary | std::ios::trunc);
    out << json.dump(1, ' ', false, Json::error_handler_t::replace) << "\n";
    out.close();
    if (!out.good()) return draft + " cannot be written";
  }
  std::error_code code;
  fs::rename(draft, file, code);
  return code ? file + " cannot be written: " + code.message() : "";
}

bool readFinishedCase(const std::string& file, const std::string& fingerprint,
                      const evaluation::WindowJournal& journal, CaseResult* result) {
  std::ifstream in(file, std::ios::binary);
  const Json json = Json::parse(in, nullptr, false);
  *result = CaseResult();
  try {
    if (json.at("fingerprint").get<std::string>() != fingerprint) return false;
    fromJson(json, result);
  } catch (const Json::exception&) {
    return false;  // another program's, or none at all
  }
  for (int trial = 0; trial < result->result.counts.trials; ++trial) {
    const evaluation::WindowRecord* window = journal.find(trial);
    if (window != nullptr) result->result.windows.push_back(*window);
  }
  if (static_cast<int>(result->result.windows.size()) != result->result.counts.windows) {
    return false;
  }
  result->summaries = evaluation::summarize(result->result);
  return true;
}

}  // namespace slim_init::tools
