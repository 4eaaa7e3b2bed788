// The one JSON document of a command's --json.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>

namespace sweepstake::cli {

// With a line break at the end; -1 puts all in one line. Bytes that are no UTF-8, as a file's name
// may hold, become U+FFFD.
void PrintJson(const nlohmann::ordered_json& document, std::ostream& out, int indent = 2);

}  // namespace sweepstake::cli
