// Fuzzes the daemon's settings from each of their sources. Accepted settings can be printed and
// read again.
#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "server/config.h"
#include "tests/fuzz/input.h"

namespace sweepstake::server {
namespace {

using fuzz::Input;
using fuzz::Require;

absl::StatusOr<Assignments> ReadFile(std::string_view text) {
  static const int file = memfd_create("config", 0);
  Require(ftruncate(file, 0) == 0 && pwrite(file, text.data(), text.size(), 0) >= 0, "a file");
  return ReadConfigFile("/proc/self/fd/" + std::to_string(file));
}

std::vector<std::string> Lines(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    lines.emplace_back(text.substr(0, text.find('\n')));
    text.remove_prefix(std::min(text.size(), lines.back().size() + 1));
  }
  return lines;
}

// Parses flags as main.cc does: any text whose key is in the table.
Assignments Flags(std::string_view text) {
  const std::vector<SettingDescription> settings = DescribeSettings();
  Assignments flags;
  for (const std::string& line : Lines(text)) {
    const size_t end = std::min(line.find('='), line.size());
    for (const SettingDescription& setting : settings) {
      if (setting.flag == line.substr(0, end)) flags[setting.key] = line.substr(end).erase(0, 1);
    }
  }
  return flags;
}

absl::StatusOr<Config> ConfigOf(const absl::StatusOr<Assignments>& assignments) {
  if (!assignments.ok()) return assignments.status();
  Config config;
  absl::Status status = Assign(*assignments, "input", config);
  if (status.ok()) status = Validate(config);
  if (!status.ok()) return status;
  return config;
}

void Run(Input input) {
  const uint8_t source = input.Byte();
  const std::string_view text = input.Rest();
  const absl::StatusOr<Config> config = source == 'f'   ? ConfigOf(ReadFile(text))
                                        : source == 'e' ? ConfigOf(ReadEnvironment(Lines(text)))
                                                        : ConfigOf(Flags(text));
  if (!config.ok()) return Require(!config.status().message().empty(), "an error has a message");
  const absl::StatusOr<Config> again = ConfigOf(ReadFile(PrintConfig(*config)));
  Require(again.ok(), "printed settings can be read");
  const ChangedKeys changed = ChangedSettings(*config, *again);
  Require(changed.live.empty() && changed.fixed.empty(), "printed settings are equal");
}

}  // namespace
}  // namespace sweepstake::server

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sweepstake::server::Run({data, size});
  return 0;
}
