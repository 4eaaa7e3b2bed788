// Derives every decision of an audit log again and compares it with the logged one
// (`sweepstake-lab replay --log`). Thread-safe.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "engine_client/decider/audit/rederive.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Reads the file into memory and returns the result of the derivation, with the first difference.
// Errors: kNotFound (the file cannot be read), kInvalidArgument (it contains no decisions).
Result<decision::AuditReport> ReplayLog(const std::string& file);

// Return the report as one JSON document and as lines of text.
nlohmann::ordered_json ReplayLogJson(const decision::AuditReport& report, const std::string& file);
std::string ReplayLogText(const decision::AuditReport& report);

}  // namespace sweepstake::cli
