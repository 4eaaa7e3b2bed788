// The outputs of `sweepstake-lab replay` (a text table and one JSON document), and the check of an
// audit log (`replay --log`).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "engine_client/decider/audit/rederive.h"
#include "tests/laboratory/replay/replay_study.h"

namespace sweepstake::cli {

struct ReplayReport {
  std::span<const StudyScene> scenes;
  const StudyOptions& options;
  std::vector<StudyRow> rows;
};

// Formats a number with its sign, as "+1.23", a ratio as "+1.23%", and an interval of ratios as
// "+1.23% to +4.56%". Values that round to 0 get a plus.
std::string Signed(double value, int decimals);
std::string SignedPercent(double ratio, int decimals = 2);
std::string IntervalText(const Interval& interval);

void PrintReplayTable(const ReplayReport& report, std::ostream& out);
void PrintReplayJson(const ReplayReport& report, std::ostream& out);

// Returns the parameters of the decision rule as JSON.
nlohmann::ordered_json DecisionJson(const decision::DecisionOptions& options);

// Returns the times of a frame as JSON. `paper` is the detection time of the policy `paper`.
nlohmann::ordered_json FrameMsJson(const FrameMs& ms, const std::optional<double>& paper);

// Derives every decision of an audit log again from the logged measurements, and compares it with
// the logged decision. Reads the file into memory and returns the result with the first difference.
// Errors: kNotFound (the file cannot be read), kInvalidArgument (it contains no decisions).
Result<decision::AuditReport> ReplayLog(const std::string& file);

// Return the report as one JSON document, and as lines of text.
nlohmann::ordered_json ReplayLogJson(const decision::AuditReport& report, const std::string& file);
std::string ReplayLogText(const decision::AuditReport& report);

}  // namespace sweepstake::cli
