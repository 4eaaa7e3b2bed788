// One HTML file that shows what commands print as JSON, without network: the page of
// tests/laboratory/report with the documents in it. Pure, except for the file.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "engine_client/cli/io/terminal.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns the page with the documents, each a JSON text, in place of its marker. No text in them
// can end the page's script.
std::string FillReportPage(std::string_view page, std::span<const std::string> documents);

// Returns kUnavailable with the reason if the program was built without the page.
Status ReportPageStatus();

// Writes the file atomically and prints its path on `terminal`. Errors: those of WholeFile and
// ReportPageStatus.
Status WriteReport(const std::string& path, std::span<const std::string> documents,
                   Terminal& terminal);

}  // namespace sweepstake::cli
