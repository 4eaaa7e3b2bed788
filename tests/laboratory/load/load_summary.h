// The figures of a load run, as JSON and as a table. Pure functions.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tests/laboratory/load/load_run.h"

namespace sweepstake::cli {

// A figure that was not measured is absent.
nlohmann::ordered_json LoadJson(const LoadPlan& plan, const LoadResult& result);
// The same figures, one per line.
std::string LoadText(const LoadPlan& plan, const LoadResult& result);

}  // namespace sweepstake::cli
