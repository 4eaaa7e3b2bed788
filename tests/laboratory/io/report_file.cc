#include "tests/laboratory/io/report_file.h"

#include <utility>

#include "tests/laboratory/report/report_page.h"

namespace sweepstake::cli {
namespace {

constexpr std::string_view kMarker = "SWEEPSTAKE_DOCUMENTS";

// Replaces each '<' by its escape. In JSON a '<' occurs only within strings, where the escape has
// the same meaning.
void AppendWithoutTags(std::string& text, std::string_view json) {
  for (const char character : json) {
    if (character == '<') {
      text += "\\u003c";
    } else {
      text += character;
    }
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

Result<std::unique_ptr<ReportFile>> ReportFile::Create(const std::string& path) {
  if (ReportPage().empty()) {
    return Status(StatusCode::kUnavailable,
                  "the report cannot be written: " + std::string(ReportPageProblem()));
  }
  auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  return std::unique_ptr<ReportFile>(new ReportFile(path, std::move(*file)));
}

Status ReportFile::Commit(std::span<const std::string> documents, Terminal& terminal) {
  file_->Write(FillReportPage(ReportPage(), documents));
  Status status = file_->Commit();
  if (status.ok()) terminal.err << "The report is in " << path_ << '\n';
  return status;
}

}  // namespace sweepstake::cli
