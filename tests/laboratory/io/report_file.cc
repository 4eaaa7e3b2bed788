#include "tests/laboratory/io/report_file.h"

#include "engine_client/cli/io/whole_file.h"
#include "tests/laboratory/report/report_page.h"

namespace sweepstake::cli {
namespace {

constexpr std::string_view kMarker = "SWEEPSTAKE_DOCUMENTS";

// Replaces each '<' by its escape. In JSON a '<' occurs only within strings, where the escape has
// the same meaning.
void AppendWithoutTags(std::string& text, std::string_view json) {
  for (const char character : json) {
    if (character == '<') text += "\\u003c";
    if (character != '<') text += character;
  }
}

}  // namespace

std::string FillReportPage(std::string_view page, std::span<const std::string> documents) {
  const size_t marker = page.find(kMarker);
  if (marker == std::string_view::npos) return std::string(page);
  std::string filled(page.substr(0, marker));
  filled += '[';
  for (const std::string& document : documents) {
    if (&document != &documents.front()) filled += ',';
    AppendWithoutTags(filled, document);
  }
  filled += ']';
  filled += page.substr(marker + kMarker.size());
  return filled;
}

Status ReportPageStatus() {
  if (!ReportPage().empty()) return {};
  return {StatusCode::kUnavailable,
          "the report cannot be written: " + std::string(ReportPageProblem())};
}

Status WriteReport(const std::string& path, std::span<const std::string> documents,
                   Terminal& terminal) {
  if (Status status = ReportPageStatus(); !status.ok()) return status;
  Status status = WriteWhole(path, FillReportPage(ReportPage(), documents));
  if (status.ok()) terminal.err << "The report is in " << path << '\n';
  return status;
}

}  // namespace sweepstake::cli
