#include "engine_client/cli/io/json_output.h"

#include "engine_client/text/names.h"

namespace sweepstake::cli {

void PrintJson(const nlohmann::ordered_json& document, std::ostream& out, int indent) {
  out << document.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
      << '\n';
}

// The text can contain names and messages of a daemon, which could control the terminal.
void PrintText(Terminal& terminal, const std::string& text) {
  terminal.out << text::PrintableLines(text) << std::flush;
}

void PrintResult(Terminal& terminal, bool as_json, const nlohmann::ordered_json& document,
                 const std::string& text, int indent) {
  if (as_json) {
    PrintJson(document, terminal.out, indent);
  } else {
    PrintText(terminal, text);
  }
}

}  // namespace sweepstake::cli
