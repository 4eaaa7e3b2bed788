// One HTML file that shows what commands print as JSON, without network: the page of
// tests/laboratory/report with the documents in it. Not thread-safe.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engine_client/cli/io/terminal.h"
#include "engine_client/cli/io/whole_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns the page with the documents, each a JSON text, in place of its marker. No text in them
// can end the page's script.
std::string FillReportPage(std::string_view page, std::span<const std::string> documents);

class ReportFile {
 public:
  // Begins to write before the long work, so that errors show early. Errors: kUnavailable (the
  // program was built without the page) and those of WholeFile.
  static Result<std::unique_ptr<ReportFile>> Create(const std::string& path);

  // Completes the file, which appears whole or not at all, and prints its path on `terminal`.
  // Errors: those of WholeFile.
  Status Commit(std::span<const std::string> documents, Terminal& terminal);

 private:
  ReportFile(std::string path, std::unique_ptr<WholeFile> file)
      : path_(std::move(path)), file_(std::move(file)) {}

  std::string path_;
  std::unique_ptr<WholeFile> file_;
};

}  // namespace sweepstake::cli
