// The table of goals: for people, and as JSON.
#pragma once

#include <ostream>
#include <span>

#include "engine_client/cli/replay/replay_goals.h"
#include "engine_client/cli/replay/replay_judgement.h"

namespace sweepstake::cli {

void PrintGoalsTable(const ReplayJudgement& judgement, std::span<const ReplayGoal> goals,
                     std::ostream& out);
void PrintGoalsJson(const ReplayJudgement& judgement, std::span<const ReplayGoal> goals,
                    std::ostream& out);

}  // namespace sweepstake::cli
