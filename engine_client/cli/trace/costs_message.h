// A cost trace as the message of its file, and back. Pure functions, safe from any thread; cost a
// copy of every number. What comes back has not been checked: costs_file.h does that.
#pragma once

#include "engine_client/cli/trace/cost_trace.h"
#include "engine_client/cli/trace/costs.pb.h"

namespace sweepstake::cli {

costs::CostTrace ToProto(const CostTrace& trace);
CostTrace FromProto(const costs::CostTrace& message);

}  // namespace sweepstake::cli
