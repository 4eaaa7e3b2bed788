#include "engine_client/cli/replay/replay_players.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "server/decision/study/ablations.h"

namespace sweepstake::cli {
namespace {

std::string Joined(std::span<const std::string> words) {
  std::string joined;
  for (const std::string& word : words) joined += (joined.empty() ? "" : ", ") + word;
  return joined;
}

std::optional<uint32_t> IndexOf(std::string_view name, std::span<const std::string> names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<uint32_t>(found - names.begin());
}

Result<ReplayPlayer> FixedPlayer(const std::string& word, std::span<const std::string> arms) {
  const auto arm = IndexOf(std::string_view(word).substr(std::string_view("fixed:").size()), arms);
  if (!arm) {
    return Status(StatusCode::kInvalidArgument,
                  "the traces have no arm for '" + word + "'; their arms are " + Joined(arms));
  }
  return ReplayPlayer{.name = word, .kind = ReplayPlayer::Kind::kFixed, .arm = *arm};
}

Status CheckPolicy(const std::string& word) {
  std::vector<std::string> names;
  for (const std::string_view name : decision::PolicyNames(decision::StudyPolicies()))
    names.emplace_back(name);
  if (IndexOf(word, names)) return {};
  return {StatusCode::kInvalidArgument, "there is no policy '" + word + "'; use " + Joined(names) +
                                            ", all, fixed, fixed:ARM, oracle"};
}

}  // namespace

Result<std::vector<ReplayPlayer>> ReplayPlayers(std::span<const std::string> words,
                                                std::span<const std::string> arms) {
  std::vector<ReplayPlayer> players;
  for (const std::string& word : words) {
    if (word == "all") {
      for (const std::string_view name : decision::PolicyNames(decision::StudyPolicies())) {
        if (name != "default") players.push_back({.name = std::string(name)});
      }
    } else if (word == "fixed") {
      for (const std::string& arm : arms) players.push_back(*FixedPlayer("fixed:" + arm, arms));
    } else if (word.starts_with("fixed:")) {
      const auto player = FixedPlayer(word, arms);
      if (!player.ok()) return player.status();
      players.push_back(*player);
    } else if (word == "oracle") {
      players.push_back({.name = word, .kind = ReplayPlayer::Kind::kOracle});
    } else {
      if (const Status status = CheckPolicy(word); !status.ok()) return status;
      players.push_back({.name = word});
    }
  }
  return players;
}

}  // namespace sweepstake::cli
