// Plans and synthetic live runs for tests of experiments. A run has three arms, an exploration of 6
// s and a window of 100 s.
#pragma once

#include <string>
#include <vector>

#include "tests/laboratory/experiment/experiment_folder.h"

namespace sweepstake::test_support {

inline const std::vector<std::string> kRecordArms{"SAP", "KDTree", "Grid"};

// The scene's seed is the number of the run. After the exploration `arm` runs for `share_percent`
// of the window and the next arm for the rest.
cli::RunRecord MakeRecord(const cli::ExperimentCell& cell, const std::string& policy, uint32_t run,
                          uint32_t arm, double share_percent);

// Returns the plan of valid options; the test fails if they are not valid.
cli::ExperimentPlan PlanOf(const cli::ExperimentOptions& options);

}  // namespace sweepstake::test_support
