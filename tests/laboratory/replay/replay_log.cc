#include "tests/laboratory/replay/replay_log.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/numbers.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;
using decision::AuditDifference;
using decision::AuditReport;

Result<std::string> ReadLog(const std::string& path) {
  std::error_code unknown;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, unknown)) {
    return Status(StatusCode::kNotFound, path + " cannot be read");
  }
  return std::string{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string Counted(uint64_t count, const std::string& what) {
  return Grouped(count) + " " + what + (count == 1 ? "" : "s");
}

Json DifferenceJson(const std::optional<AuditDifference>& difference) {
  if (!difference) return nullptr;
  return {{"line", difference->line},       {"session", difference->session},
          {"segment", difference->segment}, {"row", difference->row},
          {"column", difference->column},   {"message", difference->message}};
}

std::string UnderivedText(const AuditReport& report) {
  if (report.incomplete_segment_count == 0) return "";
  return Counted(report.underived_decision_count, "decision") + " in " +
         Counted(report.incomplete_segment_count, "segment") +
         " cannot be re-derived: earlier rows are missing, because the log is bounded or a "
         "write failed\n";
}

}  // namespace

Result<AuditReport> ReplayLog(const std::string& file) {
  const auto text = ReadLog(file);
  if (!text.ok()) return text.status();
  AuditReport report = decision::Rederive(*text, decision::StudyPolicies());
  if (!report.difference && report.decision_count + report.underived_decision_count == 0) {
    return Status(
        StatusCode::kInvalidArgument,
        file + " contains no decisions; `sweepstake audit list` shows the sessions that have some");
  }
  return report;
}

Json ReplayLogJson(const AuditReport& report, const std::string& file) {
  return {{"command", "replay"},
          {"log", file},
          {"sessions", report.session_count},
          {"segments", report.segment_count},
          {"rows", report.row_count},
          {"decisions", report.decision_count},
          {"incomplete_segments", report.incomplete_segment_count},
          {"underived_decisions", report.underived_decision_count},
          {"equal", !report.difference},
          {"difference", DifferenceJson(report.difference)}};
}

std::string ReplayLogText(const AuditReport& report) {
  return Counted(report.decision_count, "decision") + " in " +
         Counted(report.segment_count, "segment") + " re-derived, " +
         (report.difference ? "then a difference\n" + report.difference->Text() : "all equal") +
         '\n' + UnderivedText(report);
}

}  // namespace sweepstake::cli
