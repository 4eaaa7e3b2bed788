#include "server/decision/audit_log.h"

namespace sweepstake::decision {

std::string AuditHeader() {
  std::string header;
  for (const std::string_view name : kAuditColumnNames)
    header.append(header.empty() ? "" : ",").append(name);
  return header;
}

}  // namespace sweepstake::decision
