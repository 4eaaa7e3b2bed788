// `sweepstaked token create|list|revoke`: the tokens in a data directory. A running daemon applies
// a change within a second. `sweepstaked ticket`: signs a ticket, as a studio's backend does.
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
  // Adds the command with its subcommands. This object must exist until `app` has parsed the
  // command line.
  void AddTo(CLI::App& app);

  // Returns whether the command line has one of these commands.
  bool parsed() const { return token_->parsed() || ticket_->parsed(); }

  // Runs the parsed subcommand on the tokens of the directory `data`. A new token is written only
  // to `out` or to the file of --out; remarks about it go to `notes`. Errors: those of TokenStore,
  // INVALID_ARGUMENT (not a player), NOT_FOUND (no such directory, or no tokens in it) and
  // UNAVAILABLE (a file or directory cannot be read or created).
  absl::Status Run(const std::filesystem::path& data, std::ostream& out, std::ostream& notes) const;

 private:
  absl::Status Create(const std::filesystem::path& data, std::ostream& out,
                      std::ostream& notes) const;
  absl::Status List(const std::filesystem::path& data, std::ostream& out) const;
  absl::Status Revoke(const std::filesystem::path& data, std::ostream& out) const;
  absl::Status Sign(std::ostream& out) const;

  CLI::App* token_ = nullptr;
  CLI::App* ticket_ = nullptr;
  CLI::App* create_ = nullptr;
  CLI::App* list_ = nullptr;
  std::string name_;
  std::string role_;
  std::vector<std::string> projects_;
  std::optional<int64_t> days_;
  std::filesystem::path out_file_;
  bool json_ = false;
  std::string player_;
  std::filesystem::path token_file_;
  int64_t hours_ = 24;
};

}  // namespace sweepstake::server
