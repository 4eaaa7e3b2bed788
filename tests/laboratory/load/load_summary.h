// The figures of a load run, as JSON and as a table. Pure functions.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tests/laboratory/load/load_run.h"

namespace sweepstake::cli {

// Omits figures that were not measured.
nlohmann::ordered_json LoadJson(const LoadPlan& plan, const LoadResult& result);
// The same figures, one per line.
std::string LoadText(const LoadPlan& plan, const LoadResult& result);

}  // namespace sweepstake::cli
