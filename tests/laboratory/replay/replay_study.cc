#include "tests/laboratory/replay/replay_study.h"

#include <algorithm>
#include <numeric>

#include "engine_client/decider/policy/diagnosis.h"
#include "tests/laboratory/io/parallel.h"
#include "tests/laboratory/replay/replay_fixed.h"

namespace sweepstake::cli {
namespace {

// Seed of the games whose evidence becomes the priors of other games.
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
        return Judged(oracle_.regime_ns, StudyGame{.switch_count = oracle_.switch_count,
                                                   .active_share = oracle_.active_share,
                                                   .dominant_arm = oracle_.dominant_arm});
      case ReplayPlayer::Kind::kPolicy:
        break;
    }
    return Policy(player.name);
  }

 private:
  // Returns the recorded time per frame, without other work.
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

  std::vector<decision::BetaPosterior> Priors(const std::string& policy) const {
    std::vector<const ReplayScene*> others;
    for (const StudyScene& other : scenes_) {
      if (other.name != name_) others.push_back(&other.scene);  // a trace may be there twice
    }
    const uint64_t seed = seed_ + kPriorsSeed;
    return ServedPriors(options_.priors, policy, scene_, others, seed,
                        [&](const auto& scene) { return Replay(scene, SetupOf(policy, seed)); });
  }

  StudyGame Policy(const std::string& policy) const {
    ReplaySetup setup = SetupOf(policy, seed_);
    setup.priors = Priors(policy);
    const ReplayResult result = Replay(scene_, setup);
    const double total_ns = static_cast<double>(result.total_ns);
    StudyGame game{.active_share = result.active_share(),
                   .dominant_arm = result.dominant_arm(),
                   .bail_out_count = result.bail_out_count,
                   .shadow_share = static_cast<double>(result.shadow_ns) / total_ns};
    const auto& switches = result.observation.switch_counts;
    game.ms.lane =
        static_cast<double>(result.shadow_ns) / scene_.frame_count() / scene_.time_ratio() * 1e-6;
    game.reliability = result.reliability;
    game.switch_count = std::accumulate(switches.begin(), switches.end(), uint64_t{0});
    game.after_start_up_switch_count = result.after_start_up_switch_count;
    game.regret_after_start_up =
        RegretFrom(result.start_up_frame_count, static_cast<double>(result.after_start_up_ns));
    const auto tick_count =
        std::accumulate(result.verdict_counts.begin(), result.verdict_counts.end(), uint64_t{0});
    for (const uint64_t count : result.verdict_counts) {
      game.verdict_shares.push_back(static_cast<double>(count) /
                                    static_cast<double>(std::max<uint64_t>(tick_count, 1)));
    }
    const auto best = std::min_element(totals_.begin(), totals_.end()) - totals_.begin();
    if (const auto first_ns = result.first_active_ns[static_cast<size_t>(best)]) {
      game.first_best_s = static_cast<double>(*first_ns) * 1e-9;
    }
    if (result.first_choice) game.first_loss = totals_[*result.first_choice] / best_ns_ - 1;
    game.opening_regret = OpeningRegret(result);
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

std::vector<double> Column(const std::vector<StudyGame>& games, double StudyGame::*column) {
  std::vector<double> values;
  values.reserve(games.size());
  for (const StudyGame& game : games) values.push_back(game.*column);
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

void Summarize(StudyRow& row) {
  const auto& games = row.games;
  const auto regret = Column(games, &StudyGame::regret_best_fixed);
  row.regret_best_fixed = Mean(regret);
  row.ci95 = Interval95(regret);
  row.regret_oracle = Mean(Column(games, &StudyGame::regret_oracle));
  row.headroom = Mean(Column(games, &StudyGame::headroom));
  row.frame_headroom = Mean(Column(games, &StudyGame::frame_headroom));
  if (row.headroom >= kMinHeadroom) row.headroom_captured = -row.regret_best_fixed / row.headroom;
  row.active_share = Mean(Column(games, &StudyGame::active_share));
  row.shadow_share = Mean(Column(games, &StudyGame::shadow_share));
  row.dominant_arm = MostOften(games);
  row.verdict_shares.resize(games.front().verdict_shares.size());
  const double share = 1.0 / static_cast<double>(games.size());
  std::vector<double> after_start_up;
  std::vector<double> first_best_s;
  std::vector<double> first_right;
  std::vector<double> opening_regret;
  for (const StudyGame& game : games) {
    for (double FrameMs::*const time :
         {&FrameMs::detection, &FrameMs::best, &FrameMs::median, &FrameMs::worst, &FrameMs::lane})
      row.ms.*time += game.ms.*time * share;
    row.reliability += game.reliability;
    row.switches += static_cast<double>(game.switch_count) * share;
    row.after_start_up_switches += static_cast<double>(game.after_start_up_switch_count) * share;
    for (size_t i = 0; i < row.verdict_shares.size(); ++i) {
      row.verdict_shares[i] += game.verdict_shares[i] * share;
    }
    if (game.bail_out_count) {
      row.bail_outs = row.bail_outs.value_or(0) + static_cast<double>(*game.bail_out_count) * share;
    }
    if (game.regret_after_start_up) after_start_up.push_back(*game.regret_after_start_up);
    if (game.first_best_s) first_best_s.push_back(*game.first_best_s);
    if (game.first_loss) first_right.push_back(*game.first_loss <= decision::kTieLossRatio ? 1 : 0);
    if (game.opening_regret) opening_regret.push_back(*game.opening_regret);
  }
  if (!after_start_up.empty()) {
    row.regret_after_start_up = Mean(after_start_up);
    row.after_start_up_ci95 = Interval95(after_start_up);
  }
  if (!first_best_s.empty()) row.first_best_s = Median(first_best_s);
  if (!first_right.empty()) row.first_right = Mean(first_right);
  if (!opening_regret.empty()) row.opening_regret = Mean(opening_regret);
}

void Compare(StudyRow& row, const StudyRow& paper) {
  row.paper_ms = paper.ms.detection;
  std::vector<double> differences;
  for (size_t seed = 0; seed < row.games.size(); ++seed) {
    differences.push_back(row.games[seed].regret_best_fixed - paper.games[seed].regret_best_fixed);
  }
  row.against_paper = {.difference = Mean(differences),
                       .ci95 = Interval95(differences),
                       .probability = WilcoxonSignedRank(differences).probability};
}

}  // namespace

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
  for (StudyRow& row : rows) Summarize(row);
  if (paper == options.players.end()) return rows;
  const auto paper_player = static_cast<size_t>(paper - options.players.begin());
  for (StudyRow& row : rows) Compare(row, rows[row.scene * player_count + paper_player]);
  return rows;
}

}  // namespace sweepstake::cli
