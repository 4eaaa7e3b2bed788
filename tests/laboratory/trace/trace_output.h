// Shows a cost trace as text, JSON and CSV. Functions that write to a stream are not thread-safe.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>

#include "sweepstake/status.h"
#include "tests/laboratory/trace/cost_trace.h"
#include "tests/laboratory/trace/trace_summary.h"

namespace sweepstake::cli {

// Returns a row of the command's --json; `file` is the path of the trace.
nlohmann::ordered_json TraceJson(const CostTrace& trace, const TraceSummary& summary,
                                 const std::string& file);

// Prints a table of the arms and a few lines about the whole trace.
void PrintTrace(const CostTrace& trace, const TraceSummary& summary, const std::string& file,
                std::ostream& out);

// Prints a warning if the A/A control differs by too much, else nothing.
void PrintControlWarning(const CostTrace& trace, const TraceSummary& summary, std::ostream& err);

// Writes a line per frame and arm with frame, arm, objects, pairs, detection_ms, aabb_checks, bytes
// and held. The control is an arm of its own, "ARM control". Errors: those of CsvFile.
Status WriteTraceCsv(const CostTrace& trace, const std::filesystem::path& path);

}  // namespace sweepstake::cli
