// One HTML file that shows what commands print as JSON, without network: the page of
// server/dashboard with the documents in it. Not thread-safe.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engine_client/cli/io/terminal.h"
#include "engine_client/cli/io/whole_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// `page` with the documents, each a JSON text, in place of its marker. No text in them ends the
// page's script.
std::string FillReportPage(std::string_view page, std::span<const std::string> documents);

class ReportFile {
 public:
  // Begins to write, so that long work is not done in vain. kUnavailable: the program was built
  // without the page. The errors of WholeFile.
  static Result<std::unique_ptr<ReportFile>> Create(const std::string& path);

  // The file appears whole or not at all; then says on `terminal` where it is. The errors of
  // WholeFile.
  Status Commit(std::span<const std::string> documents, Terminal& terminal);

 private:
  ReportFile(std::string path, std::unique_ptr<WholeFile> file)
      : path_(std::move(path)), file_(std::move(file)) {}

  std::string path_;
  std::unique_ptr<WholeFile> file_;
};

}  // namespace sweepstake::cli
