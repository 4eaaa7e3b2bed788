#include "tests/laboratory/replay/replay_study.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "engine_client/cli/io/duration.h"
#include "engine_client/decider/session/session_setup.h"
#include "engine_client/text/counts.h"
#include "engine_client/text/names.h"
#include "tests/laboratory/policies/study_policies.h"
#include "tests/laboratory/trace/cost_trace.h"

namespace sweepstake::cli {
namespace {

Status Invalid(const std::string& message) { return {StatusCode::kInvalidArgument, message}; }

std::string Joined(std::span<const std::string> words) {
  std::string joined;
  for (const std::string& word : words) joined += (joined.empty() ? "" : ", ") + word;
  return joined;
}

Result<ReplayPlayer> FixedPlayer(const std::string& word, std::span<const std::string> arms) {
  const std::string name = word.substr(std::string_view("fixed:").size());
  const auto found = std::find(arms.begin(), arms.end(), name);
  if (found == arms.end()) {
    const std::vector<std::string_view> valid(arms.begin(), arms.end());
    return Invalid(text::UnknownName("traced arm", name, valid));
  }
  return ReplayPlayer{.name = word,
                      .kind = ReplayPlayer::Kind::kFixed,
                      .arm = static_cast<uint32_t>(found - arms.begin())};
}

Status CheckPolicy(const std::string& word) {
  if (decision::FindPolicy(word, decision::StudyPolicies()) != nullptr) return {};
  std::vector<std::string_view> valid = decision::PolicyNames(decision::StudyPolicies());
  valid.insert(valid.end(), {"all", "ablations", "fixed", "fixed:ARM", "oracle"});
  return Invalid(text::UnknownName("policy", word, valid));
}

// Returns the policies that StudyPolicies() adds to ComparedPolicies().
std::vector<ReplayPlayer> Ablations() {
  const decision::PolicyRegistry all = decision::StudyPolicies();
  std::vector<ReplayPlayer> players;
  for (const decision::PolicyEntry& entry : all.subspan(decision::ComparedPolicies().size())) {
    players.push_back({.name = std::string(entry.kind.name)});
  }
  return players;
}

Status ReadDuration(const std::string& text, uint64_t& ns) {
  if (text.empty()) return {};
  const auto duration = ParseDuration(text);
  if (!duration.ok()) return duration.status();
  ns = *duration;
  return {};
}

// Returns the options of the game on trace number `trace`.
Result<GameOptions> GameOf(const ReplayRequest& request, size_t trace) {
  GameOptions game;
  const std::string pass = request.passes.empty()       ? ""
                           : request.passes.size() == 1 ? request.passes.front()
                                                        : request.passes[trace];
  Status status = ReadDuration(request.run, game.run_ns);
  if (status.ok()) status = ReadDuration(pass, game.pass_ns);
  if (!status.ok()) return status;
  return game;
}

Result<StudyScene> ReadScene(const ReplayRequest& request, size_t trace) {
  const std::string& file = request.costs[trace];
  const auto game = GameOf(request, trace);
  if (!game.ok()) return game.status();
  const auto costs = ReadCosts(file);
  if (!costs.ok()) return costs.status();
  auto scene = ReplayScene::Create(*costs, *game);
  if (!scene.ok()) return Status(scene.status().code(), file + ": " + scene.status().message());
  return StudyScene{file, std::move(*scene)};
}

Status CheckSameArms(const std::vector<StudyScene>& scenes) {
  for (const StudyScene& each : scenes) {
    if (each.scene.arms() == scenes.front().scene.arms()) continue;
    return Invalid(each.name + " has the arms " + Joined(each.scene.arms()) + ", but " +
                   scenes.front().name + " has " + Joined(scenes.front().scene.arms()) +
                   "; replay them separately, or trace them with the same --arms");
  }
  return {};
}

Result<std::vector<StudyScene>> ReadScenes(const ReplayRequest& request) {
  if (request.passes.size() > 1 && request.passes.size() != request.costs.size()) {
    return Invalid("--pass has " + text::Counted(request.passes.size(), "duration") + " for " +
                   text::Counted(request.costs.size(), "trace") +
                   "; give one, or one for each of --costs");
  }
  std::vector<StudyScene> scenes;
  for (size_t trace = 0; trace < request.costs.size(); ++trace) {
    auto scene = ReadScene(request, trace);
    if (!scene.ok()) return scene.status();
    scenes.push_back(std::move(*scene));
  }
  if (const Status status = CheckSameArms(scenes); !status.ok()) return status;
  return scenes;
}

// Returns the lane ratio of each arm: the requested value, or 1 if the request does not name the
// arm. Empty if the request has no ratios.
Result<std::vector<double>> LaneRatios(const ReplayRequest& request,
                                       std::span<const std::string> arms) {
  std::vector<double> ratios(request.lane_ratios.empty() ? 0 : arms.size(), 1);
  for (const auto& [name, text] : request.lane_ratios) {
    const auto arm = std::find(arms.begin(), arms.end(), name);
    if (arm == arms.end()) {
      const std::vector<std::string_view> valid(arms.begin(), arms.end());
      return Invalid(text::UnknownName("traced arm", name, valid));
    }
    double ratio = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), ratio);
    if (read.ptr != text.data() + text.size() || !(ratio >= 0.01 && ratio <= 100)) {
      return Invalid("--lane-ratio " + name + ": give a ratio of 0.01 to 100, such as 0.9");
    }
    ratios[static_cast<size_t>(arm - arms.begin())] = ratio;
  }
  return ratios;
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
    } else if (word == "ablations") {
      const std::vector<ReplayPlayer> ablations = Ablations();
      players.insert(players.end(), ablations.begin(), ablations.end());
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

Result<ReplayPlan> MakeReplayPlan(const ReplayRequest& request) {
  auto scenes = ReadScenes(request);
  if (!scenes.ok()) return scenes.status();
  auto players = ReplayPlayers(request.policies, scenes->front().scene.arms());
  if (!players.ok()) return players.status();
  auto ratios = LaneRatios(request, scenes->front().scene.arms());
  if (!ratios.ok()) return ratios.status();
  const auto priors =
      std::find(kReplayPriorsNames.begin(), kReplayPriorsNames.end(), request.priors);
  if (const auto problem = decision::Validate(request.study.decision, decision::StudyPolicies())) {
    return Invalid(*problem);
  }
  const bool uses_weights =
      std::any_of(players->begin(), players->end(), [](const ReplayPlayer& player) {
        return player.kind == ReplayPlayer::Kind::kPolicy &&
               !decision::PolicyKindOf(player.name, decision::StudyPolicies()).goes_by_cost();
      });
  if (request.study.decision.weights != RewardWeights() && !uses_weights)
    return Invalid("--weights needs a policy with the paper's reward, such as --policy paper");
  ReplayPlan plan{.scenes = std::move(*scenes), .study = request.study};
  plan.study.players = std::move(*players);
  plan.study.priors = static_cast<ReplayPriors>(priors - kReplayPriorsNames.begin());
  if (request.no_shadow) plan.study.shadow_lane = false;
  plan.study.lane_errors.arm_ratios = std::move(*ratios);
  return plan;
}

}  // namespace sweepstake::cli
