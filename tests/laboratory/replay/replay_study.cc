#include "tests/laboratory/replay/replay_study.h"

#include <algorithm>
#include <numeric>

#include "engine_client/decider/policy/diagnosis.h"
#include "tests/laboratory/io/parallel.h"

namespace sweepstake::cli {
namespace {

// The seed of the games whose evidence becomes the priors of the games that are compared.
constexpr uint64_t kPriorsSeed = 1'000'000'007;

// Plays the games of one seed on one scene.
class SeedGames {
 public:
  SeedGames(std::span<const StudyScene> scenes, size_t scene, const StudyOptions& options,
            uint64_t seed)
      : scenes_(scenes),
        name_(scenes[scene].name),
        scene_(scenes[scene].scene),
        options_(options),
        seed_(seed),
        fixed_(scene_, seed),
        totals_(fixed_.TotalsFrom(0)),
        best_ns_(*std::min_element(totals_.begin(), totals_.end())),
        oracle_(fixed_.Oracle(options.decision.decision_interval_ns,
                              options.shadow_lane.value_or(true))) {}

  StudyGame Play(const ReplayPlayer& player) const {
    switch (player.kind) {
      case ReplayPlayer::Kind::kFixed:
        return Fixed(player.arm);
      case ReplayPlayer::Kind::kOracle:
        return Judged(oracle_.regime_ns,
                      StudyGame{.switches = static_cast<double>(oracle_.switch_count),
                                .active_share = oracle_.active_share,
                                .dominant_arm = oracle_.dominant_arm});
      case ReplayPlayer::Kind::kPolicy:
        break;
    }
    return Policy(player.name);
  }

 private:
  // Converts a game's total time to recorded milliseconds per frame, without other work.
  double MsOf(double total_ns) const {
    const double frame_ns = total_ns / scene_.frame_count();
    const auto other_ns = static_cast<double>(scene_.options().other_work_ns);
    return (frame_ns - other_ns) / scene_.time_ratio() * 1e-6;
  }
  void Judge(double total_ns, StudyGame& game) const {
    game.ms.detection = MsOf(total_ns);
    game.ms.best = MsOf(best_ns_);
    game.ms.median = MsOf(Median(totals_));
    game.ms.worst = MsOf(*std::max_element(totals_.begin(), totals_.end()));
    game.regret_best_fixed = total_ns / best_ns_ - 1;
    game.regret_oracle = total_ns / oracle_.regime_ns - 1;
    game.headroom = 1 - oracle_.regime_ns / best_ns_;
    game.frame_headroom = 1 - oracle_.frame_ns / best_ns_;
  }
  StudyGame Judged(double total_ns, const StudyGame& unjudged) const {
    StudyGame game = unjudged;
    Judge(total_ns, game);
    return game;
  }

  std::optional<double> RegretFrom(uint32_t first_frame, double ns) const {
    if (first_frame == scene_.frame_count()) return std::nullopt;
    const std::vector<double> totals = fixed_.TotalsFrom(first_frame);
    return ns / *std::min_element(totals.begin(), totals.end()) - 1;
  }

  StudyGame Fixed(uint32_t arm) const {
    const uint64_t start_up = static_cast<uint64_t>(kStartUpNs) / scene_.options().frame_ns;
    const auto first_frame =
        static_cast<uint32_t>(std::min<uint64_t>(start_up, scene_.frame_count()));
    StudyGame game{.dominant_arm = arm};
    game.regret_after_start_up = RegretFrom(first_frame, fixed_.TotalsFrom(first_frame)[arm]);
    Judge(totals_[arm], game);
    return game;
  }

  double OpeningRegret(const ReplayResult& result) const {
    const std::vector<double> after = fixed_.TotalsFrom(result.opening_frame_count);
    double best_ns = totals_[0] - after[0];
    for (size_t arm = 1; arm < after.size(); ++arm)
      best_ns = std::min(best_ns, totals_[arm] - after[arm]);
    return static_cast<double>(result.opening_ns) / best_ns - 1;
  }

  ReplaySetup SetupOf(const std::string& policy, uint64_t seed) const {
    ReplaySetup setup{
        .options = options_.decision, .seed = seed, .shadow_lane = options_.shadow_lane};
    setup.options.policy = policy;
    setup.shadow = options_.shadow;
    setup.lane_errors = options_.lane_errors;
    setup.frame_load = options_.frame_load;
    return setup;
  }

  decision::Prior PriorOf(const std::string& policy) const {
    std::vector<const ReplayScene*> others;
    for (const StudyScene& other : scenes_) {
      // Skip this trace, which may be given twice.
      if (other.name != name_) others.push_back(&other.scene);
    }
    const uint64_t seed = seed_ + kPriorsSeed;
    return ServedPrior(options_.priors, policy, scene_, others, seed,
                       [&](const auto& scene) { return Replay(scene, SetupOf(policy, seed)); });
  }

  StudyGame Policy(const std::string& policy) const {
    ReplaySetup setup = SetupOf(policy, seed_);
    const decision::Prior prior = PriorOf(policy);
    setup.priors = prior.posteriors();
    setup.regime_priors = prior.regimes;
    const ReplayResult result = Replay(scene_, setup);
    const double total_ns = static_cast<double>(result.total_ns);
    const auto& switches = result.observation.switch_counts;
    const auto best = std::min_element(totals_.begin(), totals_.end()) - totals_.begin();
    StudyGame game{
        .switches = std::accumulate(switches.begin(), switches.end(), 0.0),
        .after_start_up_switches = static_cast<double>(result.after_start_up_switch_count),
        .active_share = result.active_share(),
        .shadow_share = static_cast<double>(result.shadow_ns) / total_ns,
        .regret_after_start_up =
            RegretFrom(result.start_up_frame_count, static_cast<double>(result.after_start_up_ns)),
        .bail_outs = static_cast<double>(result.bail_out_count),
        .opening_regret = OpeningRegret(result),
        .reliability = result.reliability,
        .dominant_arm = result.dominant_arm()};
    game.ms.lane =
        static_cast<double>(result.shadow_ns) / scene_.frame_count() / scene_.time_ratio() * 1e-6;
    const double tick_count =
        std::accumulate(result.verdict_counts.begin(), result.verdict_counts.end(), 0.0);
    for (const uint64_t count : result.verdict_counts) {
      game.verdict_shares.push_back(static_cast<double>(count) / std::max(tick_count, 1.0));
    }
    if (const auto first_ns = result.first_active_ns[static_cast<size_t>(best)]) {
      game.first_best_s = static_cast<double>(*first_ns) * 1e-9;
    }
    if (result.first_choice) {
      const double loss = totals_[*result.first_choice] / best_ns_ - 1;
      game.first_right = loss <= decision::kTieLossRatio ? 1 : 0;
    }
    return Judged(total_ns, game);
  }

  const std::span<const StudyScene> scenes_;
  const std::string& name_;
  const ReplayScene& scene_;
  const StudyOptions& options_;
  const uint64_t seed_;
  const FixedCosts fixed_;
  const std::vector<double> totals_;
  const double best_ns_;
  const FixedCosts::OracleCost oracle_;
};

// Returns the values of one figure. Leaves out games in which the figure is absent.
template <typename Figure>
std::vector<double> Column(const std::vector<StudyGame>& games, Figure StudyGame::*figure) {
  std::vector<double> values;
  for (const StudyGame& game : games) {
    const std::optional<double> value = game.*figure;
    if (value) values.push_back(*value);
  }
  return values;
}

Interval Interval95(const std::vector<double>& values) {
  return BootstrapMean(values, {.resample_count = 2000});
}

uint32_t MostOften(const std::vector<StudyGame>& games) {
  std::vector<uint32_t> counts(decision::kMaxArms);
  for (const StudyGame& game : games) ++counts[game.dominant_arm];
  return static_cast<uint32_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

}  // namespace

void SummarizeGames(StudyRow& row) {
  const auto& games = row.games;
  for (double StudyGame::*const figure :
       {&StudyGame::regret_best_fixed, &StudyGame::regret_oracle, &StudyGame::headroom,
        &StudyGame::frame_headroom, &StudyGame::switches, &StudyGame::after_start_up_switches,
        &StudyGame::active_share, &StudyGame::shadow_share}) {
    row.*figure = Mean(Column(games, figure));
  }
  for (std::optional<double> StudyGame::*const figure :
       {&StudyGame::regret_after_start_up, &StudyGame::bail_outs, &StudyGame::first_right,
        &StudyGame::opening_regret}) {
    const std::vector<double> values = Column(games, figure);
    if (!values.empty()) row.*figure = Mean(values);
  }
  if (const auto first_best_s = Column(games, &StudyGame::first_best_s); !first_best_s.empty()) {
    row.first_best_s = Median(first_best_s);
  }
  row.ci95 = Interval95(row.Values(&StudyGame::regret_best_fixed));
  if (row.regret_after_start_up) {
    row.after_start_up_ci95 = Interval95(Column(games, &StudyGame::regret_after_start_up));
  }
  if (row.headroom >= kMinHeadroom) row.headroom_captured = -row.regret_best_fixed / row.headroom;
  row.dominant_arm = MostOften(games);
  row.verdict_shares.resize(games.front().verdict_shares.size());
  const double share = 1.0 / static_cast<double>(games.size());
  for (const StudyGame& game : games) {
    for (double FrameMs::*const time :
         {&FrameMs::detection, &FrameMs::best, &FrameMs::median, &FrameMs::worst, &FrameMs::lane})
      row.ms.*time += game.ms.*time * share;
    row.reliability += game.reliability;
    for (size_t i = 0; i < row.verdict_shares.size(); ++i) {
      row.verdict_shares[i] += game.verdict_shares[i] * share;
    }
  }
}

PairedComparison Compare(const std::string& policy, std::span<const double> ours,
                         const std::string& baseline, std::span<const double> theirs) {
  std::vector<double> differences;
  differences.reserve(ours.size());
  for (size_t i = 0; i < ours.size(); ++i) differences.push_back(ours[i] - theirs[i]);
  PairedComparison comparison;
  comparison.policy = policy;
  comparison.baseline = baseline;
  comparison.difference = Mean(differences);
  comparison.ci95 = BootstrapMean(differences);
  comparison.wilcoxon = WilcoxonSignedRank(differences);
  comparison.corrected_probability = comparison.wilcoxon.probability;
  return comparison;
}

std::vector<double> StudyRow::Values(double StudyGame::*figure) const {
  return Column(games, figure);
}

std::vector<StudyRow> RunStudy(std::span<const StudyScene> scenes, const StudyOptions& options,
                               const std::function<void(uint64_t, uint64_t)>& on_game) {
  const size_t player_count = options.players.size();
  std::vector<StudyRow> rows(scenes.size() * player_count);
  for (size_t i = 0; i < rows.size(); ++i) {
    rows[i].scene = static_cast<uint32_t>(i / player_count);
    rows[i].player = static_cast<uint32_t>(i % player_count);
    rows[i].games.resize(options.seed_count);
  }
  const uint64_t job_count = scenes.size() * uint64_t{options.seed_count};
  RunParallel(
      job_count, options.thread_count,
      [&](uint64_t job) {
        const size_t scene = job / options.seed_count;
        const uint64_t seed = job % options.seed_count;
        const SeedGames games(scenes, scene, options, seed + 1);
        for (size_t player = 0; player < player_count; ++player) {
          rows[scene * player_count + player].games[seed] = games.Play(options.players[player]);
        }
      },
      [&](uint64_t done) { on_game(done * player_count, job_count * player_count); });
  const auto paper = std::find_if(options.players.begin(), options.players.end(),
                                  [](const ReplayPlayer& each) { return each.name == "paper"; });
  for (StudyRow& row : rows) SummarizeGames(row);
  if (paper == options.players.end()) return rows;
  const auto paper_player = static_cast<size_t>(paper - options.players.begin());
  for (StudyRow& row : rows) {
    const StudyRow& of_paper = rows[row.scene * player_count + paper_player];
    row.paper_ms = of_paper.ms.detection;
    row.against_paper =
        Compare(options.players[row.player].name, row.Values(&StudyGame::regret_best_fixed),
                paper->name, of_paper.Values(&StudyGame::regret_best_fixed));
  }
  return rows;
}

}  // namespace sweepstake::cli
