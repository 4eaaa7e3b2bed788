#include "engine_client/cli/commands.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <map>
#include <memory>
#include <thread>

#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/replay/replay_cells.h"
#include "engine_client/cli/replay/replay_goals.h"
#include "engine_client/cli/replay/replay_goals_output.h"
#include "engine_client/cli/replay/replay_judgement.h"
#include "engine_client/cli/replay/replay_log.h"
#include "engine_client/cli/replay/replay_output.h"
#include "engine_client/cli/replay/replay_study.h"
#include "engine_client/cli/trace/costs_file.h"
#include "server/decision/study/ablations.h"

namespace sweepstake::cli {
namespace {

struct ReplayCommandOptions {
  std::vector<std::string> costs;
  std::string goals_file;
  std::string trace_folder;
  std::string log_file;
  std::vector<std::string> policies = {"default", "paper"};
  uint32_t seed_count = 30;
  std::string run = "15m";
  std::string pass;
  std::string frame = "10ms";
  std::string other_work;
  bool no_shadow = false;
  std::string priors = "none";
  uint32_t thread_count = std::max(std::thread::hardware_concurrency(), 1U);
  std::string csv_file;
  bool json = false;
};

const std::map<std::string, ReplayPriors> kPriors = {{"none", ReplayPriors::kNone},
                                                     {"right", ReplayPriors::kRight},
                                                     {"wrong", ReplayPriors::kWrong}};

Status Read(const std::string& text, uint64_t& ns) {
  if (text.empty()) return {};
  const auto duration = ParseDuration(text);
  if (!duration.ok()) return duration.status();
  ns = *duration;
  return {};
}

Result<GameOptions> ReadGame(const ReplayCommandOptions& options) {
  GameOptions game;
  for (const auto& [text, ns] : {std::pair(&options.run, &game.run_ns),
                                 {&options.pass, &game.pass_ns},
                                 {&options.frame, &game.frame_ns},
                                 {&options.other_work, &game.other_work_ns}}) {
    if (const Status status = Read(*text, *ns); !status.ok()) return status;
  }
  return game;
}

std::string Joined(const std::vector<std::string>& words) {
  std::string joined;
  for (const std::string& word : words) joined += (joined.empty() ? "" : ", ") + word;
  return joined;
}

Result<StudyScene> ReadScene(const std::string& file, const GameOptions& game) {
  const auto trace = ReadCosts(file);
  if (!trace.ok()) return trace.status();
  auto scene = ReplayScene::Create(*trace, game);
  if (!scene.ok()) return Status(scene.status().code(), file + ": " + scene.status().message());
  return StudyScene{file, std::move(*scene)};
}

Status CheckSameArms(const std::vector<StudyScene>& scenes) {
  for (const StudyScene& each : scenes) {
    if (each.scene.arms() == scenes.front().scene.arms()) continue;
    return {StatusCode::kInvalidArgument,
            each.name + " has the arms " + Joined(each.scene.arms()) + ", but " +
                scenes.front().name + " has " + Joined(scenes.front().scene.arms()) +
                "; replay them apart, or trace them with the same --arms"};
  }
  return {};
}

Result<std::vector<StudyScene>> ReadScenes(const ReplayCommandOptions& options) {
  const auto game = ReadGame(options);
  if (!game.ok()) return game.status();
  std::vector<StudyScene> scenes;
  for (const std::string& file : options.costs) {
    auto scene = ReadScene(file, *game);
    if (!scene.ok()) return scene.status();
    scenes.push_back(std::move(*scene));
  }
  if (Status status = CheckSameArms(scenes); !status.ok()) return status;
  return scenes;
}

Result<std::vector<StudyScene>> ReadScenesOf(const std::vector<ReplayCell>& cells,
                                             const ReplayCommandOptions& options) {
  auto game = ReadGame(options);
  if (!game.ok()) return game.status();
  std::vector<StudyScene> scenes;
  for (const ReplayCell& cell : cells) {
    game->pass_ns = cell.pass_ns;
    const auto file = std::filesystem::path(options.trace_folder) / (cell.name() + ".costs");
    auto scene = ReadScene(file.string(), *game);
    if (!scene.ok()) return scene.status();
    scene->name = cell.name();
    scenes.push_back(std::move(*scene));
  }
  if (Status status = CheckSameArms(scenes); !status.ok()) return status;
  return scenes;
}

Result<StudyOptions> ReadStudy(const ReplayCommandOptions& options,
                               const std::vector<StudyScene>& scenes) {
  auto players = ReplayPlayers(options.policies, scenes.front().scene.arms());
  if (!players.ok()) return players.status();
  StudyOptions study;
  study.players = std::move(*players);
  study.seed_count = options.seed_count;
  study.priors = kPriors.at(options.priors);
  if (options.no_shadow) study.shadow_lane = false;
  study.thread_count = options.thread_count;
  return study;
}

// How far it is, and when it will be done.
class StudyProgress {
 public:
  explicit StudyProgress(Terminal& terminal) : terminal_(terminal) {}

  std::function<void(uint64_t done, uint64_t all)> listener() {
    return [this](uint64_t done, uint64_t all) { Show(done, all); };
  }

 private:
  void Show(uint64_t done, uint64_t all) {
    if (!progress_) progress_.emplace(terminal_, "replay", all);
    if (!progress_->due()) return;
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin_;
    const double left_s =
        spent.count() * static_cast<double>(all - done) / static_cast<double>(done);
    progress_->Show(done, std::to_string(done) + " of " + std::to_string(all) + " games, " +
                              std::to_string(static_cast<uint64_t>(left_s) + 1) + " s left");
  }

  Terminal& terminal_;
  std::optional<Progress> progress_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

int ReplayTraces(const ReplayCommandOptions& options, Terminal& terminal) {
  const auto scenes = ReadScenes(options);
  if (!scenes.ok()) return Fail(terminal, scenes.status());
  const auto study = ReadStudy(options, *scenes);
  if (!study.ok()) return Fail(terminal, study.status());
  std::unique_ptr<CsvFile> csv;
  if (!options.csv_file.empty()) {
    auto created = CreateReplayCsv(options.csv_file);
    if (!created.ok()) return Fail(terminal, created.status());
    csv = std::move(*created);
  }
  std::vector<StudyRow> rows;
  {
    StudyProgress progress(terminal);
    rows = RunStudy(*scenes, *study, progress.listener());
  }
  const ReplayReport report{*scenes, *study, rows};
  if (options.json) {
    PrintReplayJson(report, terminal.out);
  } else {
    PrintReplayTable(report, terminal.out);
  }
  if (csv == nullptr) return kDone;
  WriteReplayCsv(report, *csv);
  const Status status = csv->Commit();
  return status.ok() ? kDone : Fail(terminal, status);
}

Status CheckJudged(const StudyOptions& study) {
  const auto is_paper = [](const ReplayPlayer& player) { return player.name == "paper"; };
  if (study.players.front().kind != ReplayPlayer::Kind::kPolicy ||
      std::none_of(study.players.begin(), study.players.end(), is_paper)) {
    return {StatusCode::kInvalidArgument,
            "--goals judges the first --policy against paper: begin with a policy, and name paper"};
  }
  return {};
}

int ReplayGoals(const ReplayCommandOptions& options, Terminal& terminal) {
  const auto cells = ReadCells(options.goals_file);
  if (!cells.ok()) return Fail(terminal, cells.status());
  auto scenes = ReadScenesOf(*cells, options);
  if (!scenes.ok()) return Fail(terminal, scenes.status());
  const auto study = ReadStudy(options, *scenes);
  if (!study.ok()) return Fail(terminal, study.status());
  if (const Status status = CheckJudged(*study); !status.ok()) return Fail(terminal, status);
  std::optional<StudyProgress> progress(terminal);
  const ReplayJudgement judgement =
      JudgePolicy(*cells, std::move(*scenes), *study, progress->listener());
  progress.reset();
  const std::vector<ReplayGoal> goals = JudgeGoals(judgement.judged(), judgement.decision_p99_ms);
  if (options.json) {
    PrintGoalsJson(judgement, goals, terminal.out);
  } else {
    PrintGoalsTable(judgement, goals, terminal.out);
  }
  const bool missed = std::any_of(goals.begin(), goals.end(),
                                  [](const ReplayGoal& goal) { return goal.reached && !goal.met; });
  return missed ? kCheckFailed : kDone;
}

int RunReplay(const ReplayCommandOptions& options, Terminal& terminal) {
  const bool given[] = {!options.costs.empty(), !options.goals_file.empty(),
                        !options.log_file.empty()};
  if (std::count(std::begin(given), std::end(given), true) != 1) {
    return Fail(terminal, Status(StatusCode::kInvalidArgument,
                                 "give one of --costs FILE.costs, --goals SCENES.txt --traces "
                                 "FOLDER, and --log FILE.csv"));
  }
  if (!options.log_file.empty()) return ReplayLog(options.log_file, options.json, terminal);
  return options.costs.empty() ? ReplayGoals(options, terminal) : ReplayTraces(options, terminal);
}

void Declare(CLI::App& command, ReplayCommandOptions& options) {
  command.add_option("--costs", options.costs, "Cost traces, made by `sweepstake trace`")
      ->delimiter(',');
  CLI::Option* goals = command.add_option("--goals", options.goals_file,
                                          "Judge the first policy on the scenes of this list");
  CLI::Option* traces =
      command.add_option("--traces", options.trace_folder, "Folder with the traces of --goals")
          ->needs(goals);
  goals->needs(traces);
  command.add_option("--log", options.log_file,
                     "Derive every decision of this audit log again, and compare");
  command
      .add_option("--policy", options.policies,
                  "Policies, or all; fixed for every arm, fixed:ARM, oracle")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--seeds", options.seed_count, "Games of each policy on each trace")
      ->check(CLI::Range(uint32_t{1}, uint32_t{100'000}))
      ->capture_default_str();
  command.add_option("--run", options.run, "Virtual time of a game on the best fixed arm")
      ->capture_default_str();
  command.add_option("--pass", options.pass,
                     "Virtual time of one pass through the trace (default: the run)");
  command.add_option("--frame", options.frame, "Mean frame of the best fixed arm")
      ->capture_default_str();
  command.add_option("--other-work", options.other_work,
                     "Of the frame, beside detection (default: nothing)");
  command.add_flag("--no-shadow", options.no_shadow,
                   "Without the shadow lane; else the policies that learn from it have it");
  command
      .add_option(
          "--priors", options.priors,
          "right: what another seed's game has learnt; wrong: that with the ranking reversed")
      ->check(CLI::IsMember({"none", "right", "wrong"}))
      ->capture_default_str();
  command.add_option("--threads", options.thread_count, "Games played at a time")
      ->check(CLI::Range(uint32_t{1}, uint32_t{256}))
      ->capture_default_str();
  command.add_option("--csv", options.csv_file, "Every game as a row of this file");
  command.add_flag("--json", options.json, "One JSON document on stdout");
}

}  // namespace

void AddReplayCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  std::string policies;
  for (const std::string_view name : decision::PolicyNames(decision::StudyPolicies()))
    policies.append(" ").append(name);
  AddCommand<ReplayCommandOptions>(
      app, "replay",
      "Let policies play recorded cost traces in virtual time, or decisions be derived again",
      "  sweepstake replay --costs hurricane.costs --policy default,paper,fixed --seeds 200\n"
      "  sweepstake replay --costs a.costs,b.costs --policy default,oracle --priors wrong --json\n"
      "  sweepstake replay --costs a.costs --policy fixed:SAP,default --pass 3m --csv games.csv\n"
      "  sweepstake replay --goals tests/bench/held_out_scenes.txt --traces build/traces\n"
      "  sweepstake replay --log decisions.csv\n"
      "Policies:" +
          policies +
          "\nRegret is frame time against the best fixed arm's on the same frames; negative is "
          "better.\n",
      exit_code, Declare,
      [&terminal](const ReplayCommandOptions& options) { return RunReplay(options, terminal); });
}

}  // namespace sweepstake::cli
