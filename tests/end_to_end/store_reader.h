// Reads what a stopped daemon has left on disk.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine_client/decider/audit/audit_row.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::test_support {

// Returns the state of one source in the store under the daemon's data directory; fails the test if
// it is missing or cannot be read.
priors::SourceState ReadSource(const std::filesystem::path& data, const std::string& source_id);

// Returns all scenes of the store; fails the test if they cannot be read.
std::vector<priors::SceneEvidence> ReadScenes(const std::filesystem::path& data);

// Returns the audit log of all sessions in the store.
std::vector<decision::AuditRow> ReadAuditLog(const std::filesystem::path& data);

// Returns the evidence of a source, summed over its arms.
priors::Evidence TotalEvidence(const priors::SourceState& source);

// Expects that no increment of a session with the policy "paper" was lost or applied twice: α + β
// counts one per window and ten per bail-out.
void ExpectConsistent(const priors::SourceState& source);

}  // namespace sweepstake::test_support
