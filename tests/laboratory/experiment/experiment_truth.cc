#include "tests/laboratory/experiment/experiment_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string_view>

#include "engine_client/decider/options.h"
#include "engine_client/decider/session/policy_registry.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::cli {
namespace {

constexpr double kNormal95 = 1.96;

// Returns the players that replay compares: AI Decides, its baselines, each arm alone, and the
// oracle.
std::vector<ReplayPlayer> JudgedPlayers(std::span<const std::string> arms) {
  std::vector<std::string> words;
  for (const std::string_view policy : decision::PolicyNames(decision::ComparedPolicies())) {
    if (policy != "default") words.emplace_back(policy);
  }
  words.insert(words.end(), {"fixed", "oracle"});
  return *ReplayPlayers(words, arms);
}

void CorrectByHolm(std::vector<PairedComparison>& family) {
  std::vector<double> probabilities;
  for (const PairedComparison& each : family) {
    probabilities.push_back(each.wilcoxon.probability);
  }
  const std::vector<double> corrected = HolmCorrected(probabilities);
  for (size_t i = 0; i < family.size(); ++i) family[i].corrected_probability = corrected[i];
}

// Returns whether AI Decides is compared with this player.
bool IsBaseline(const ReplayedPlayer& player) {
  const bool is_always = player.name == "fixed:" + std::string(kAlwaysArm);
  return (player.is_policy && player.name != OwnPolicyName("default")) || is_always;
}

std::vector<PairedComparison> CompareInCell(const std::vector<ReplayedPlayer>& players) {
  const std::string own = OwnPolicyName("default");
  std::vector<PairedComparison> comparisons;
  const auto ours = std::find_if(players.begin(), players.end(),
                                 [&](const ReplayedPlayer& each) { return each.name == own; });
  for (const ReplayedPlayer& theirs : players) {
    if (!IsBaseline(theirs)) continue;
    comparisons.push_back(Compare(own, ours->scene_regrets, theirs.name, theirs.scene_regrets));
  }
  CorrectByHolm(comparisons);
  return comparisons;
}

std::optional<Worth> WorthOf(const std::vector<ReplayedPlayer>& players) {
  Worth worth;
  worth.best_ms = std::numeric_limits<double>::infinity();
  constexpr std::string_view kFixed = "fixed:";
  for (const ReplayedPlayer& player : players) {
    const double ms = player.row.ms.detection;
    if (player.name == "oracle") worth.oracle_ms = ms;
    if (player.name == OwnPolicyName("default")) worth.decided_ms = ms;
    if (!player.name.starts_with(kFixed)) continue;
    const std::string arm = player.name.substr(kFixed.size());
    if (arm == kAlwaysArm) worth.always_ms = ms;
    if (ms >= worth.best_ms) continue;
    worth.best_ms = ms;
    worth.best_arm = arm;
  }
  return worth.always_ms > 0 ? std::optional(worth) : std::nullopt;
}

// Returns the cell's games on each of its traces, as scenes of a study.
Result<std::vector<StudyScene>> ReplayScenes(std::span<const CostTrace> traces, GameOptions game,
                                             bool in_real_time) {
  std::vector<StudyScene> scenes;
  for (const CostTrace& trace : traces) {
    if (in_real_time) game.pass_ns = std::min(game.run_ns, game.frame_ns * trace.frame_count);
    auto scene = ReplayScene::Create(trace, game);
    if (!scene.ok()) return scene.status();
    scenes.push_back({std::to_string(trace.seed), std::move(*scene)});
  }
  return scenes;
}

// Returns the games per scene, so that all scenes together have at least seed_count games.
uint32_t GamesPerScene(const TruthOptions& options, size_t scene_count) {
  const auto count = static_cast<uint32_t>(scene_count);
  return (options.seed_count + count - 1) / count;
}

// Joins the rows of one player on the scenes of a cell.
ReplayedPlayer Joined(const ReplayPlayer& player, std::span<const StudyRow* const> rows) {
  ReplayedPlayer joined{player.name, player.kind == ReplayPlayer::Kind::kPolicy, {}, {}};
  std::vector<double> paper_ms;
  for (const StudyRow* row : rows) {
    joined.row.games.insert(joined.row.games.end(), row->games.begin(), row->games.end());
    joined.scene_regrets.push_back(row->regret_best_fixed);
    paper_ms.push_back(*row->paper_ms);
  }
  SummarizeGames(joined.row);
  joined.row.paper_ms = Mean(paper_ms);
  joined.row.ci95 = BootstrapMean(joined.scene_regrets);
  return joined;
}

// The frame times and the length of the live runs of one cell and policy. The virtual game of the
// replay uses the same values.
struct LiveScale {
  uint64_t frame_ns = 1;       // mean frame time of the best arm, all work included
  uint64_t other_work_ns = 0;  // the part of frame_ns that is not detection
  uint64_t run_ns = 1;
};

uint64_t Whole(double value) { return static_cast<uint64_t>(std::max(1.0, std::round(value))); }

double MeanNs(uint64_t ns, const ArmActivity& activity) {
  return static_cast<double>(ns) / static_cast<double>(std::max<uint64_t>(activity.frame_count, 1));
}
double FrameNs(const ArmActivity& activity) { return MeanNs(activity.active_ns, activity); }
double DetectionNs(const ArmActivity& activity) { return MeanNs(activity.detection_ns, activity); }

LiveScale ScaleOf(const std::vector<PlayedRun>& runs) {
  std::vector<double> frame_ns, other_ns, run_ns;
  for (const PlayedRun& run : runs) {
    const auto& controls = run.record->controls;
    const ArmActivity& best = *std::min_element(
        controls.begin(), controls.end(),
        [](const auto& a, const auto& b) { return DetectionNs(a) < DetectionNs(b); });
    frame_ns.push_back(FrameNs(best));
    other_ns.push_back(FrameNs(best) - DetectionNs(best));
    run_ns.push_back(run.record->end_s * 1e9);
  }
  const uint64_t frame = std::max<uint64_t>(2, Whole(Median(frame_ns)));
  return {frame, std::min(frame - 1, Whole(Median(other_ns))), Whole(Median(run_ns))};
}

// Returns the mean regret over the frames of the whole run, exploration included.
double MeasuredRegret(const RunRecord& record, uint32_t best_arm) {
  ArmActivity all;
  for (const auto* activities : {&record.explored, &record.observed}) {
    for (const ArmActivity& each : *activities) {
      all.frame_count += each.frame_count;
      all.active_ns += each.active_ns;
    }
  }
  return FrameNs(all) / FrameNs(record.controls[best_arm]) - 1;
}

double RegretByTrace(const RunRecord& record, std::span<const double> costs_ns,
                     double other_work_ns) {
  double ns = 0, frames = 0;
  for (size_t arm = 0; arm < record.arms.size(); ++arm) {
    const auto count =
        static_cast<double>(record.explored[arm].frame_count + record.observed[arm].frame_count);
    ns += count * (costs_ns[arm] + other_work_ns);
    frames += count;
  }
  const double best_ns = *std::min_element(costs_ns.begin(), costs_ns.end()) + other_work_ns;
  return ns / frames / best_ns - 1;
}

// Returns the mean cost of each arm over the frames of a trace, in ns.
std::vector<double> MeanCosts(const CostTrace& trace) {
  std::vector<double> costs(trace.arm_count());
  for (uint32_t frame = 0; frame < trace.frame_count; ++frame) {
    for (uint32_t arm = 0; arm < trace.arm_count(); ++arm) {
      costs[arm] += static_cast<double>(trace.detection(frame, arm)) / trace.frame_count;
    }
  }
  return costs;
}

double ControlRatio(const CostTrace& trace) {
  const auto control = std::accumulate(trace.control_ns.begin(), trace.control_ns.end(), 0.0);
  return control / trace.frame_count / MeanCosts(trace)[trace.control_arm];
}

Interval Predicted(const std::vector<double>& games, size_t run_count) {
  const double width =
      kNormal95 * SampleDeviation(games) *
      std::sqrt(1.0 / static_cast<double>(run_count) + 1.0 / static_cast<double>(games.size()));
  return {Mean(games) - width, Mean(games) + width};
}

std::vector<double> Column(const std::vector<LiveRegret>& runs, double LiveRegret::*column) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const LiveRegret& run : runs) values.push_back(run.*column);
  return values;
}

// Computes the figures of the live runs. The intervals that replay expects are added by Agree.
Agreement LiveFigures(const CellSummary& cell, std::span<const CostTrace> traces,
                      double other_work_ns) {
  std::map<uint64_t, std::vector<double>> scene_costs;  // by the scene's seed
  for (const CostTrace& trace : traces) scene_costs[trace.seed] = MeanCosts(trace);
  Agreement agreement;
  agreement.policy = cell.policy;
  for (const PlayedRun& run : cell.runs) {
    const std::vector<double>& costs = scene_costs.at(run.record->scene_seed);
    const auto best =
        static_cast<uint32_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
    agreement.runs.push_back({run.record->run, MeasuredRegret(*run.record, best),
                              RegretByTrace(*run.record, costs, other_work_ns),
                              run.active_shares[run.dominant]});
  }
  agreement.measured_regret = Mean(Column(agreement.runs, &LiveRegret::measured));
  agreement.regret = Mean(Column(agreement.runs, &LiveRegret::by_trace));
  agreement.active_share = Mean(Column(agreement.runs, &LiveRegret::active_share));
  return agreement;
}

// Replays the policy under the conditions of the live runs: their frame time, other work, window
// and time scale.
Result<Agreement> Agree(std::span<const CostTrace> traces, const CellSummary& cell,
                        const TruthOptions& options) {
  const LiveScale scale = ScaleOf(cell.runs);
  GameOptions game;
  game.frame_ns = scale.frame_ns;
  game.other_work_ns = scale.other_work_ns;
  game.run_ns = std::max(scale.run_ns, scale.frame_ns);
  const auto scenes = ReplayScenes(traces, game, true);
  if (!scenes.ok()) return scenes.status();
  StudyOptions study;
  study.players = {{.name = cell.policy}};
  study.decision = options.decision.Scaled(options.time_scale);
  study.shadow.sweep_interval_min_ns = static_cast<uint64_t>(
      static_cast<double>(study.shadow.sweep_interval_min_ns) / options.time_scale);
  study.seed_count = GamesPerScene(options, traces.size());
  study.thread_count = options.thread_count;
  const auto rows = RunStudy(*scenes, study, [](uint64_t, uint64_t) {});
  Agreement agreement = LiveFigures(cell, traces, static_cast<double>(scale.other_work_ns));
  const auto predicted = [&](double StudyGame::*figure) {
    std::vector<double> games;
    for (const StudyRow& row : rows) {
      const std::vector<double> values = row.Values(figure);
      games.insert(games.end(), values.begin(), values.end());
    }
    return Predicted(games, cell.runs.size());
  };
  agreement.replayed_regret = predicted(&StudyGame::regret_best_fixed);
  agreement.replayed_active_share = predicted(&StudyGame::active_share);
  agreement.replayed_active_share.low = std::max(0.0, agreement.replayed_active_share.low);
  agreement.replayed_active_share.high = std::min(1.0, agreement.replayed_active_share.high);
  return agreement;
}

bool Holds(const Interval& interval, double value) {
  return value >= interval.low && value <= interval.high;
}

}  // namespace

bool Worth::is_nothing() const {
  const auto is_little = [](double saved_ms, double of_ms) {
    return saved_ms < std::max(kMinHeadroom * of_ms, kMinWorthMs);
  };
  return is_little(saved_to_best_ms(), best_ms) && is_little(saved_to_always_ms(), always_ms);
}

bool Agreement::regret_agrees() const { return Holds(replayed_regret, regret); }
bool Agreement::share_agrees() const { return Holds(replayed_active_share, active_share); }

const CellTruth* ExperimentTruths::Of(const ExperimentCell& cell) const {
  const auto truth = std::find_if(cells.begin(), cells.end(),
                                  [&](const CellTruth& each) { return each.cell == cell; });
  return truth == cells.end() ? nullptr : &*truth;
}

std::string OwnPolicyName(const std::string& policy) {
  return std::string(decision::PolicyKindOf(policy, decision::StudyPolicies()).name);
}

CellTruth RankArms(const ExperimentCell& cell, std::span<const CostTrace> traces) {
  CellTruth truth;
  truth.cell = cell;
  truth.scene_count = static_cast<uint32_t>(traces.size());
  for (const TracedArm& arm : traces.front().arms) truth.ranking.push_back({arm.name, 0, 1});
  for (const CostTrace& trace : traces) {
    const std::vector<double> costs = MeanCosts(trace);
    for (size_t arm = 0; arm < costs.size(); ++arm) {
      truth.ranking[arm].mean_ns += costs[arm] / static_cast<double>(traces.size());
    }
    const double control_ratio = ControlRatio(trace);
    if (std::abs(control_ratio - 1) > std::abs(truth.control_ratio - 1)) {
      truth.control_ratio = control_ratio;
    }
  }
  std::sort(truth.ranking.begin(), truth.ranking.end(),
            [](const ArmCost& a, const ArmCost& b) { return a.mean_ns < b.mean_ns; });
  for (ArmCost& each : truth.ranking) each.ratio = each.mean_ns / truth.ranking.front().mean_ns;
  return truth;
}

Status AssessCell(std::span<const CostTrace> traces, std::span<const CellSummary* const> cells,
                  const TruthOptions& options, const std::function<void(double share)>& done,
                  CellTruth& truth) {
  const auto scenes = ReplayScenes(traces, {}, false);
  if (!scenes.ok()) return scenes.status();
  StudyOptions study;
  study.players = JudgedPlayers(scenes->front().scene.arms());
  study.decision = options.decision;
  study.seed_count = GamesPerScene(options, traces.size());
  study.thread_count = options.thread_count;
  const auto rows = RunStudy(*scenes, study, [&](uint64_t games, uint64_t all) {
    done(static_cast<double>(games) / static_cast<double>(all));
  });
  truth.players.clear();
  for (uint32_t player = 0; player < study.players.size(); ++player) {
    std::vector<const StudyRow*> by_scene;
    for (const StudyRow& row : rows) {
      if (row.player == player) by_scene.push_back(&row);
    }
    truth.players.push_back(Joined(study.players[player], by_scene));
  }
  truth.headroom = truth.players.front().row.headroom;
  truth.worth = WorthOf(truth.players);
  truth.comparisons = CompareInCell(truth.players);
  truth.agreements.clear();
  for (const CellSummary* cell : cells) {
    auto agreement = Agree(traces, *cell, options);
    if (!agreement.ok()) return agreement.status();
    truth.agreements.push_back(*agreement);
  }
  return {};
}

std::vector<PairedComparison> CompareOverCells(std::span<const CellTruth> truths) {
  const std::string own = OwnPolicyName("default");
  // The baselines, in the order of their first appearance.
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> means;  // by policy: one mean per cell
  for (const CellTruth& truth : truths) {
    for (const ReplayedPlayer& player : truth.players) {
      const bool is_baseline = IsBaseline(player);
      if (!is_baseline && player.name != own) continue;
      if (is_baseline && means[player.name].empty()) order.push_back(player.name);
      means[player.name].push_back(player.row.regret_best_fixed);
    }
  }
  std::vector<PairedComparison> comparisons;
  comparisons.reserve(order.size());
  for (const std::string& baseline : order) {
    comparisons.push_back(Compare(own, means[own], baseline, means[baseline]));
  }
  CorrectByHolm(comparisons);
  return comparisons;
}

}  // namespace sweepstake::cli
