// What a daemon that is not running has left on disk.
#pragma once

#include <filesystem>
#include <string>

#include "server/priors/prior_store.h"

namespace sweepstake::test_support {

// State of one source in the store under the daemon's data directory; fails the test when it cannot
// be read or is not there.
priors::SourceState ReadSource(const std::filesystem::path& data, const std::string& source_id);

// The audit log of all sessions in the store, as CSV.
std::string ReadAuditLog(const std::filesystem::path& data);

// Evidence of a source, summed over arms.
priors::Evidence TotalEvidence(const priors::SourceState& source);

}  // namespace sweepstake::test_support
