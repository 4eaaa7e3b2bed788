// The outputs of `sweepstake-lab replay`: a text table, one JSON document, and a CSV file of all
// games.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <ostream>
#include <span>
#include <string>

#include "engine_client/cli/io/csv_file.h"
#include "tests/laboratory/replay/replay_study.h"

namespace sweepstake::cli {

struct ReplayReport {
  std::span<const StudyScene> scenes;
  const StudyOptions& options;
  std::span<const StudyRow> rows;
};

void PrintReplayTable(const ReplayReport& report, std::ostream& out);
void PrintReplayJson(const ReplayReport& report, std::ostream& out);

// Returns the times of a frame; `paper` is the detection time of the policy paper.
nlohmann::ordered_json FrameMsJson(const FrameMs& ms, const std::optional<double>& paper);

// Writes one row per game. Errors: those of CsvFile.
Result<std::unique_ptr<CsvFile>> CreateReplayCsv(const std::string& path);
void WriteReplayCsv(const ReplayReport& report, CsvFile& csv);

}  // namespace sweepstake::cli
