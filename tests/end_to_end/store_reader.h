// What a daemon that is not running has left on disk.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/sessions/prior_store.h"

namespace sweepstake::test_support {

// State of one source in the store under the daemon's data directory; fails the test when it cannot
// be read or is not there.
priors::SourceState ReadSource(const std::filesystem::path& data, const std::string& source_id);

// All scenes of the store; fails the test when they cannot be read.
std::vector<priors::SceneEvidence> ReadScenes(const std::filesystem::path& data);

// The audit log of all sessions in the store, as AuditCsv has it.
std::string ReadAuditLog(const std::filesystem::path& data);

// Evidence of a source, summed over arms.
priors::Evidence TotalEvidence(const priors::SourceState& source);

// Expects of a session of the policy "paper" that no increment was lost or applied twice: α + β
// counts one per window and ten per bail-out.
void ExpectConsistent(const priors::SourceState& source);

}  // namespace sweepstake::test_support
