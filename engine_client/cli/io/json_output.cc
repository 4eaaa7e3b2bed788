#include "engine_client/cli/io/json_output.h"

#include <nlohmann/json.hpp>

namespace sweepstake::cli {

void PrintJson(const nlohmann::ordered_json& document, std::ostream& out, int indent) {
  out << document.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
      << '\n';
}

}  // namespace sweepstake::cli
