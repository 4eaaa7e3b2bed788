// Fuzzes the daemon's settings from each source. An accepted configuration can be printed and read
// again.
#include <sys/mman.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/config.h"
#include "tests/fuzz/input.h"

namespace sweepstake::server {
namespace {

using fuzz::Input;
using fuzz::Require;

absl::Status ReadFile(Settings& settings, std::string_view text) {
  static const int file = memfd_create("config", 0);
  Require(ftruncate(file, 0) == 0 && pwrite(file, text.data(), text.size(), 0) >= 0, "a file");
  return settings.ReadFile("/proc/self/fd/" + std::to_string(file));
}

std::vector<std::string> Lines(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    lines.emplace_back(text.substr(0, text.find('\n')));
    text.remove_prefix(std::min(text.size(), lines.back().size() + 1));
  }
  return lines;
}

absl::Status ReadFlags(CLI::App& app, std::string_view text) {
  std::vector<std::string> words = Lines(text);
  std::reverse(words.begin(), words.end());  // CLI11 expects the words in reverse order
  try {
    app.parse(words);
  } catch (const CLI::Error& error) {
    return absl::InvalidArgumentError(std::string("flags: ") + error.what());
  }
  return absl::OkStatus();
}

// Reads from a file ('f'), the environment ('e') or else the command line.
absl::StatusOr<Config> Read(uint8_t source, std::string_view text) {
  CLI::App app;
  Config config;
  Settings settings(app, config);
  absl::Status status = source == 'f'   ? ReadFile(settings, text)
                        : source == 'e' ? settings.ReadEnvironment(Lines(text))
                                        : ReadFlags(app, text);
  if (status.ok()) status = Validate(config);
  if (!status.ok()) return status;
  return config;
}

void Run(Input input) {
  const uint8_t source = input.Byte();
  const std::string_view text = input.Rest();
  const absl::StatusOr<Config> config = Read(source, text);
  if (!config.ok()) return Require(!config.status().message().empty(), "an error has a message");
  const absl::StatusOr<Config> again = Read('f', PrintConfig(*config));
  Require(again.ok(), "the printed configuration can be read");
  const ChangedKeys changed = ChangedSettings(*config, *again);
  Require(changed.live.empty() && changed.fixed.empty(),
          "the printed configuration has the same values");
}

}  // namespace
}  // namespace sweepstake::server

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sweepstake::server::Run({data, size});
  return 0;
}
