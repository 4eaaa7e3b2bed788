// How a segment of the audit log begins: all of a session's setup and where it runs, as a cell and
// back. Pure functions.
//
// key=value pairs separated by semicolons, in a fixed order; items of lists separated by commas. A
// backslash stands before each of \ ; , in a text.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/decision/audit_log.h"
#include "server/decision/decision_session.h"

namespace sweepstake::decision {

// But for the session's id and the segment, which have columns of their own.
void AppendSetup(std::string& out, const SessionSetup& setup, const AuditOrigin& origin);

struct AuditSetup {
  SessionSetup setup;
  AuditOrigin origin;
};
// `problem` gets what is wrong where it is absent.
std::optional<AuditSetup> ParseSetup(std::string_view text, std::string& problem);

}  // namespace sweepstake::decision
