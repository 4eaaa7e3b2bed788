// Converts audit rows to protobuf messages and back. The struct and the message have the same field
// names (decider/audit/audit_row.h), so protobuf's reflection finds the fields by name.
#pragma once

#include <string>

#include "engine_client/decider/audit/audit_row.h"
#include "sweepstake/v1/audit.pb.h"

namespace sweepstake {

v1::AuditRow ToProto(const decision::AuditRow& row);
// Returns the serialized message, which stores keep.
std::string EncodeAuditRow(const decision::AuditRow& row);
decision::AuditRow FromProto(const v1::AuditRow& message);

}  // namespace sweepstake
