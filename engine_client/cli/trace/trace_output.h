// A cost trace as people and programs read it. Not thread-safe where it writes to a stream.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>

#include "engine_client/cli/trace/cost_trace.h"
#include "engine_client/cli/trace/trace_summary.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// A row of the command's --json; `file` is where the trace is.
nlohmann::ordered_json TraceJson(const CostTrace& trace, const TraceSummary& summary,
                                 const std::string& file);

// A table of the arms and a few lines on the whole.
void PrintTrace(const CostTrace& trace, const TraceSummary& summary, const std::string& file,
                std::ostream& out);

// A line about an A/A control that is too far off; nothing for a fair one.
void PrintControlWarning(const CostTrace& trace, const TraceSummary& summary, std::ostream& err);

// A line per frame and arm, the control as an arm of its own, "ARM control": frame, arm, objects,
// pairs, detection_ms, aabb_checks, bytes, held. The errors of CsvFile.
Status WriteTraceCsv(const CostTrace& trace, const std::filesystem::path& path);

}  // namespace sweepstake::cli
