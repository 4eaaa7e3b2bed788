// All scenes a daemon knows, page by page.
#pragma once

#include <string>
#include <vector>

#include "sweepstake/status.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

// Empty `project` or `scene`: all. kUnavailable: no daemon answered.
Result<std::vector<v1::ScenePosterior>> ListPosteriors(const std::string& address,
                                                       const std::string& project,
                                                       const std::string& scene);

}  // namespace sweepstake::cli
