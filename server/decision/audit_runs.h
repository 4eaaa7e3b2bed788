// What the frames since the last event came to, as a cell of the audit log: the state of the arms'
// runs. Pure functions.
//
// "1 2:5:…": whether the running tick has seen frames of the active run; the members of that run,
// those of its window last; and, where frames have shown a later run, its members.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/decision/arm_runs.h"

namespace sweepstake::decision {

void AppendRuns(std::string& out, const ArmRuns& runs);

// Absent: no such text, or no runs of so many arms; sums that are negative or not finite are none.
std::optional<ArmRuns> ParseRuns(std::string_view text, uint32_t arm_count);

}  // namespace sweepstake::decision
