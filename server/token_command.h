// `sweepstaked token create|list|revoke`: the tokens in a data directory. A daemon that runs sees a
// change within a second.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace sweepstake::server {

class TokenCommand {
 public:
  // Adds the command with its own subcommands. `app` and this object outlive each other's use.
  void AddTo(CLI::App& app);

  // Runs what the command line asked for, on the tokens of the directory `data`. A token is shown
  // on `out`, or written to the file that was named, and nowhere else; what else there is to say of
  // one that is shown goes to `notes`. Errors: those of TokenStore, NOT_FOUND (there is no such
  // directory, or there are no tokens in it) and UNAVAILABLE (a file or directory cannot be made).
  absl::Status Run(const std::filesystem::path& data, std::ostream& out, std::ostream& notes) const;

 private:
  absl::Status Create(const std::filesystem::path& data, std::ostream& out,
                      std::ostream& notes) const;
  absl::Status List(const std::filesystem::path& data, std::ostream& out) const;
  absl::Status Revoke(const std::filesystem::path& data, std::ostream& out) const;

  CLI::App* create_ = nullptr;
  CLI::App* list_ = nullptr;
  std::string name_;
  std::string role_;
  std::vector<std::string> projects_;
  std::optional<int64_t> days_;
  std::filesystem::path out_file_;
  bool json_ = false;
};

}  // namespace sweepstake::server
