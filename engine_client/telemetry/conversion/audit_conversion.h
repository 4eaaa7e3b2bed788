// Audit rows as protobuf messages, and back. Both sides have the same fields under the same names
// (decider/audit/audit_row.h), which are found by reflection.
#pragma once

#include <string>

#include "engine_client/decider/audit/audit_row.h"
#include "sweepstake/v1/audit.pb.h"

namespace sweepstake {

v1::AuditRow ToProto(const decision::AuditRow& row);
// Returns the message's bytes, which stores keep.
std::string EncodeAuditRow(const decision::AuditRow& row);
decision::AuditRow FromProto(const v1::AuditRow& message);

}  // namespace sweepstake
