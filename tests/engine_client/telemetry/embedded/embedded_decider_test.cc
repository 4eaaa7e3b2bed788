#include "sweepstake/embedded_decider.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/options.h"
#include "engine_client/decider/types.h"
#include "sweepstake/machine_class.h"

namespace sweepstake {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kMs = 1'000'000;
const std::vector<std::string> kArms = {"SAP", "DBVT", "KDTree"};
const std::vector<uint32_t> kVersions = {1, 1, 2};

// A game in virtual time. Each arm has a fixed cost per frame.
class Game {
 public:
  explicit Game(std::vector<uint64_t> frame_ms) : frame_ms_(std::move(frame_ms)) {}

  void RunFor(EmbeddedDecider& decider, uint64_t duration_ms) {
    const uint64_t end_ns = now_ns + duration_ms * kMs;
    while (now_ns < end_ns) Frame(decider, frame_ms_[arm]);
  }

  void Frame(EmbeddedDecider& decider, uint64_t frame_ms) {
    now_ns += frame_ms * kMs;
    FrameSample sample{};
    sample.frame_index = frame_index++;
    sample.frame_time_ns = frame_ms * kMs;
    sample.detection_time_ns = sample.frame_time_ns * detection_percent / 100;
    sample.object_count = 1000;
    sample.arm = arm;
    sample.switch_epoch = epoch;
    if (frame_ms > 5000) sample.flags = kFrameBailOut;
    decider.Observe(std::vector{sample}, now_ns);
    const auto command = decider.Poll(now_ns);
    if (command) Obey(*command);
  }

  void Obey(const SwitchCommand& command) {
    commands.push_back(command);
    if (command.arm == arm) return;
    arm = command.arm;
    ++epoch;
  }

  uint64_t now_ns = 0;
  uint64_t frame_index = 0;
  uint32_t arm = 0;
  uint32_t epoch = 0;
  uint64_t detection_percent = 75;
  std::vector<SwitchCommand> commands;

 private:
  std::vector<uint64_t> frame_ms_;
};

EmbeddedOptions PaperOptions() {
  EmbeddedOptions options;
  options.policy = "paper";
  return options;
}

std::unique_ptr<EmbeddedDecider> MakeDecider(const EmbeddedOptions& options = PaperOptions()) {
  auto made = EmbeddedDecider::Create(options, kArms, kVersions, 0);
  EXPECT_TRUE(made.ok()) << made.status().message();
  return std::move(*made);
}

double MeanOf(const ArmBelief& belief) { return belief.alpha / (belief.alpha + belief.beta); }

TEST(EmbeddedDecider, StartsAtBetaOneOneWithoutPriors) {
  const auto decider = MakeDecider();
  ASSERT_EQ(decider->beliefs().size(), 3U);
  for (const ArmBelief& belief : decider->beliefs()) {
    EXPECT_EQ(belief.alpha, 1);
    EXPECT_EQ(belief.beta, 1);
    EXPECT_FALSE(belief.standing);
  }
  EXPECT_EQ(decider->prior_source_count(), 0U);
}

TEST(EmbeddedDecider, TriesEveryArmAndThenPrefersTheFastest) {
  const auto decider = MakeDecider();
  Game game({30, 60, 15});
  game.RunFor(*decider, 400'000);
  std::vector<bool> tried(3);
  for (const SwitchCommand& command : game.commands) tried[command.arm] = true;
  EXPECT_TRUE(tried[1] && tried[2]);
  const auto beliefs = decider->beliefs();
  EXPECT_GT(MeanOf(beliefs[2]), MeanOf(beliefs[0]));
  EXPECT_GT(MeanOf(beliefs[2]), MeanOf(beliefs[1]));
  EXPECT_GT(decider->decision_count(), 100U);
}

// Observes a sweep of the lane over arms whose frames take 30, 60 and 15 ms.
void ObserveSweep(EmbeddedDecider& decider, const Game& game) {
  for (const uint32_t arm : {0U, 1U, 2U}) {
    ShadowSample sample{};
    sample.first_frame_index = game.frame_index;
    sample.detection_time_ns = (arm == 2 ? 11 : 22 * (arm + 1)) * kMs;
    sample.arm = arm;
    sample.object_count = 1000;
    sample.frame_count = 5;
    sample.flags = arm == game.arm ? uint32_t{kShadowActive} : 0U;
    decider.Observe({&sample, 1});
  }
}

TEST(EmbeddedDecider, LearnsFromTheShadowLaneWhichArmIsTheBest) {
  EmbeddedOptions options;
  options.policy = "adaptive";
  const auto decider = MakeDecider(options);
  Game game({30, 60, 15});
  for (int sweep = 0; sweep < 20 && game.arm == 0; ++sweep) {
    ObserveSweep(*decider, game);
    game.RunFor(*decider, 1000);
  }
  ASSERT_EQ(game.commands.size(),
            1U);  // The decider switches at once to the best arm, without trying it live.
  EXPECT_EQ(game.commands[0].arm, 2U);
  EXPECT_EQ(game.commands[0].reason, SwitchReason::kPolicy);
}

// Detection takes 75 % of a frame: 45 ms with the arm at the start, and 11 ms with the best one.
TEST(EmbeddedDecider, SavesAgainstTheArmAtTheStart) {
  EmbeddedOptions options;
  options.policy = "adaptive";
  options.initial_arm = 1;
  const auto decider = MakeDecider(options);
  EXPECT_FALSE(decider->saved_us());
  Game game({30, 60, 15});
  game.arm = 1;
  decider->SetMode(Mode::kAi, 1, 0);
  for (int sweep = 0; sweep < 40; ++sweep) {
    ObserveSweep(*decider, game);
    game.RunFor(*decider, 1000);
  }
  EXPECT_EQ(game.arm, 2U);
  EXPECT_NEAR(decider->saved_us().value_or(0), 33'750, 5'000);
  options.initial_arm = 3;
  EXPECT_FALSE(EmbeddedDecider::Create(options, kArms, kVersions, 0).ok());
}

TEST(EmbeddedDecider, UsesSceneDescriptors) {
  EmbeddedOptions options;
  options.policy = "adaptive";
  const auto with = MakeDecider(options);
  const auto without = MakeDecider(options);
  Game told({30, 60, 15});
  Game untold({30, 60, 15});
  for (int second = 0; second < 400; ++second) {
    with->Observe(SceneDescriptor{.object_count = second % 2 == 0 ? 100.0F : 50'000.0F,
                                  .density_ratio = -1,
                                  .static_ratio = 0.5F});
    told.RunFor(*with, 1000);
    untold.RunFor(*without, 1000);
  }
  // A policy that depends on the scene decides differently for another scene.
  const auto means = [](const EmbeddedDecider& decider) {
    std::vector<double> values;
    for (const ArmBelief& belief : decider.beliefs()) values.push_back(MeanOf(belief));
    return values;
  };
  EXPECT_NE(means(*with), means(*without));
}

TEST(EmbeddedDecider, DecidesTheSameFromTheSameSeed) {
  Game first({30, 60, 15});
  Game second({30, 60, 15});
  first.RunFor(*MakeDecider(), 200'000);
  second.RunFor(*MakeDecider(), 200'000);
  ASSERT_EQ(first.commands.size(), second.commands.size());
  for (size_t i = 0; i < first.commands.size(); ++i) {
    EXPECT_EQ(first.commands[i].arm, second.commands[i].arm);
  }
}

TEST(EmbeddedDecider, ReportsEveryDecisionInOrder) {
  std::vector<DecisionEvent> told;
  EmbeddedOptions options = PaperOptions();
  options.on_decision = [&](const DecisionEvent& event) { told.push_back(event); };
  const auto decider = MakeDecider(options);
  Game game({30, 60, 15});
  game.RunFor(*decider, 100'000);
  ASSERT_GT(told.size(), 10U);
  ASSERT_EQ(told.size(), decider->decision_count());
  for (size_t i = 0; i < told.size(); ++i) EXPECT_EQ(told[i].decision_id, i + 1);
}

TEST(EmbeddedDecider, ReportsBeliefsAndCommandWithEachDecision) {
  std::vector<DecisionEvent> told;
  EmbeddedOptions options = PaperOptions();
  options.on_decision = [&](const DecisionEvent& event) { told.push_back(event); };
  const auto decider = MakeDecider(options);
  Game game({30, 60, 15});
  game.RunFor(*decider, 100'000);
  std::vector<uint32_t> commanded;
  for (const DecisionEvent& event : told) {
    if (event.command) commanded.push_back(event.command->arm);
  }
  ASSERT_EQ(commanded.size(), game.commands.size());
  for (size_t i = 0; i < commanded.size(); ++i) EXPECT_EQ(commanded[i], game.commands[i].arm);
  const std::vector<ArmBelief> beliefs = decider->beliefs();
  ASSERT_TRUE(beliefs[0].standing);
  EXPECT_GT(beliefs[0].standing->live_window_count, 0U);
  EXPECT_NEAR(beliefs[0].standing->effective_window_count, beliefs[0].alpha + beliefs[0].beta - 2,
              1e-9);
  EXPECT_EQ(beliefs[1].standing->best_probability, told.back().best_probability[1]);
  ASSERT_EQ(told.back().beliefs.size(), beliefs.size());
  for (size_t arm = 0; arm < beliefs.size(); ++arm) {
    EXPECT_EQ(told.back().beliefs[arm].arm, beliefs[arm].arm);
    EXPECT_EQ(told.back().beliefs[arm].alpha, beliefs[arm].alpha);
    EXPECT_EQ(told.back().beliefs[arm].beta, beliefs[arm].beta);
  }
  EXPECT_EQ(told.back().verdict.verdict, decider->verdict().verdict);
  EXPECT_EQ(told.back().best_probability[decider->verdict().leader_arm],
            decider->verdict().leader_probability);
  EXPECT_TRUE(told.back().reward);
  EXPECT_EQ(decider->last_decision()->decision_id, told.back().decision_id);
}

// The policy `paper` leaves an arm after any long frame, whatever caused it.
TEST(EmbeddedDecider, AnswersABailOutAtOnce) {
  const auto decider = MakeDecider();
  Game game({20, 20, 20});
  game.detection_percent = 1;
  game.RunFor(*decider, 100'000);
  const uint32_t before = game.arm;
  const double beta_before = decider->beliefs()[before].beta;
  const size_t commands_before = game.commands.size();
  // Sampling again may keep the arm; each bail-out (ten observations without reward) makes it less
  // likely.
  for (int i = 0; i < 10 && game.commands.size() == commands_before; ++i) {
    game.Frame(*decider, 6000);
  }
  EXPECT_GE(decider->beliefs()[before].beta, beta_before + 10);
  ASSERT_GT(game.commands.size(), commands_before);
  EXPECT_EQ(game.commands[commands_before].reason, SwitchReason::kBailOut);
}

TEST(EmbeddedDecider, LearnsNothingInManualMode) {
  const auto decider = MakeDecider();
  decider->SetMode(Mode::kManual, 1, 0);
  Game game({20, 20, 20});
  game.arm = 1;
  game.RunFor(*decider, 100'000);
  EXPECT_TRUE(game.commands.empty());
  for (const ArmBelief& belief : decider->beliefs()) EXPECT_EQ(belief.alpha, 1);
}

TEST(EmbeddedDecider, IgnoresOutcomesOfEarlierEpochsAndUnknownArms) {
  const auto decider = MakeDecider();
  Game game({20, 20, 20});
  game.RunFor(*decider, 60'000);
  ASSERT_GT(game.epoch, 1U);
  const auto before = decider->beliefs();
  decider->Observe(SwitchOutcome{.arm = 0, .switch_epoch = 1, .executed = 1}, game.now_ns);
  decider->Observe(SwitchOutcome{.arm = 99, .switch_epoch = 99, .executed = 1}, game.now_ns);
  decider->Observe(SwitchOutcome{.arm = 1, .switch_epoch = 99, .executed = 0}, game.now_ns);
  game.RunFor(*decider, 10'000);
  double evidence_before = 0;
  double evidence_after = 0;
  for (const ArmBelief& belief : before) evidence_before += belief.alpha + belief.beta;
  for (const ArmBelief& belief : decider->beliefs()) evidence_after += belief.alpha + belief.beta;
  EXPECT_GT(evidence_after, evidence_before);
}

class EmbeddedDeciderPriors : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ =
        std::filesystem::path(::testing::TempDir()) /
        (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".json");
  }
  void TearDown() override { std::filesystem::remove(path_); }

  void Write(const std::vector<PriorRecord>& records) const {
    std::ofstream(path_, std::ios::binary) << FormatPriors(records);
  }

  static PriorRecord RecordOf(const std::string& arm, uint32_t version, const std::string& source) {
    PriorRecord record;
    record.key.project = record.key.scene = "default";
    record.key.machine_class = MachineClass();
    record.key.arm = arm;
    record.key.backend_version = version;
    record.key.reward_version = 1;
    record.source_id = source;
    record.source_sequence = 1;
    record.evidence.alpha = 10;
    record.evidence.beta = 5;
    return record;
  }

  EmbeddedOptions Options() const {
    EmbeddedOptions options = PaperOptions();
    options.priors_file = path_.string();
    return options;
  }

  std::filesystem::path path_;
};

TEST_F(EmbeddedDeciderPriors, AreTheSumOfTheSourcesOfMatchingArms) {
  std::vector<PriorRecord> records = {RecordOf("SAP", 1, "a"), RecordOf("SAP", 1, "b"),
                                      RecordOf("KDTree", 1, "c"), RecordOf("Octopus", 1, "d")};
  records.push_back(RecordOf("DBVT", 1, "e"));
  records.back().key.scene = "another";
  records.push_back(RecordOf("DBVT", 1, "f"));
  records.back().key.machine_class = "phone";
  records.push_back(RecordOf("DBVT", 1, "g"));
  records.back().key.reward_version = 2;
  Write(records);
  const auto decider = MakeDecider(Options());
  // As in a daemon, the count includes the scene's sources of other arms and versions.
  EXPECT_EQ(decider->prior_source_count(), 4U);
  EXPECT_EQ(decider->beliefs()[0].alpha, 21);
  EXPECT_EQ(decider->beliefs()[0].beta, 11);
  EXPECT_EQ(decider->beliefs()[1].alpha, 1);
  EXPECT_EQ(decider->beliefs()[2].alpha, 1);  // the prior has another backend version
}

TEST_F(EmbeddedDeciderPriors, HaveTheRewardVersionOfThePolicy) {
  std::vector<PriorRecord> records = {RecordOf("SAP", 1, "a"), RecordOf("SAP", 1, "b"),
                                      RecordOf("DBVT", 1, "c")};
  records[1].key.reward_version = records[2].key.reward_version = 3;
  Write(records);
  EXPECT_EQ(MakeDecider(Options())->prior_source_count(), 1U);
  EmbeddedOptions adaptive = Options();
  adaptive.policy = "adaptive";
  EXPECT_EQ(MakeDecider(adaptive)->prior_source_count(), 2U);
}

TEST_F(EmbeddedDeciderPriors, ErrorsNameTheInvalidRecord) {
  PriorRecord broken = RecordOf("SAP", 1, "a");
  broken.evidence.alpha = -1;
  Write({RecordOf("SAP", 1, "x"), broken});
  const auto made = EmbeddedDecider::Create(Options(), kArms, kVersions, 0);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.status().code(), StatusCode::kDataLoss);
  EXPECT_THAT(made.status().message(), HasSubstr("record 1"));
}

EmbeddedOptions OptionsOfPlayer(const std::string& priors_data) {
  EmbeddedOptions options;
  options.source_id = "player";
  options.priors_data = priors_data;
  return options;
}

// Lets the default policy learn for a minute, and returns the exported priors.
std::string LearnFrom(const std::string& priors_data) {
  const auto decider = MakeDecider(OptionsOfPlayer(priors_data));
  Game game({30, 60, 15});
  game.RunFor(*decider, 60'000);
  return decider->ExportPriors();
}

std::vector<PriorRecord> RecordsOf(const std::string& priors) {
  auto records = ParsePriors(priors);
  EXPECT_TRUE(records.ok()) << records.status().message();
  return std::move(*records);
}

uint64_t WindowCount(const std::string& priors) {
  uint64_t count = 0;
  for (const PriorRecord& record : RecordsOf(priors)) count += record.evidence.window_count;
  return count;
}

TEST(EmbeddedDeciderExport, IsTheStartOfTheNextRun) {
  const std::string first = LearnFrom("");
  const std::vector<PriorRecord> records = RecordsOf(first);
  ASSERT_GT(records.size(), 0U);
  EXPECT_GT(WindowCount(first), 10U);
  for (const PriorRecord& record : records) EXPECT_EQ(record.source_id, "player");

  const auto next = MakeDecider(OptionsOfPlayer(first));
  EXPECT_EQ(next->prior_source_count(), 1U);
  EXPECT_EQ(next->ExportPriors(), first) << "the decider has not learnt yet";

  const std::string second = LearnFrom(first);
  EXPECT_GT(WindowCount(second), WindowCount(first) + 10);
  for (const PriorRecord& before : records) {
    for (const PriorRecord& after : RecordsOf(second)) {
      if (after.key.arm != before.key.arm) continue;
      EXPECT_GE(after.evidence.alpha, before.evidence.alpha);
      EXPECT_EQ(after.source_sequence > before.source_sequence,
                after.evidence.window_count > before.evidence.window_count);
    }
  }
}

// Evidence of other weights than the default has a reward version of its own.
TEST(EmbeddedDeciderExport, IsUsedOnlyWithTheSameWeights) {
  EmbeddedOptions own = PaperOptions();
  own.weights = {0.25, 0.25, 0.5, 0};
  const auto decider = MakeDecider(own);
  Game game({30, 60, 15});
  game.RunFor(*decider, 60'000);
  own.priors_data = decider->ExportPriors();
  EXPECT_EQ(MakeDecider(own)->prior_source_count(), 1U);
  EmbeddedOptions usual = own;
  usual.weights = {};
  EXPECT_EQ(MakeDecider(usual)->prior_source_count(), 0U);
  EmbeddedOptions other = own;
  other.weights = {0.25, 0.5, 0.25, 0};
  EXPECT_EQ(MakeDecider(other)->prior_source_count(), 0U);
}

TEST(EmbeddedDeciderExport, ContainsTheFinalBeliefs) {
  const auto decider = MakeDecider(PaperOptions());  // its beliefs are the sums of its evidence
  Game game({30, 60, 15});
  game.RunFor(*decider, 100'000);
  game.Frame(*decider, 6000);
  EmbeddedOptions options = PaperOptions();
  options.priors_data = decider->ExportPriors();
  const auto next = MakeDecider(options);
  for (size_t arm = 0; arm < kArms.size(); ++arm) {
    EXPECT_DOUBLE_EQ(next->beliefs()[arm].alpha, decider->beliefs()[arm].alpha);
    EXPECT_DOUBLE_EQ(next->beliefs()[arm].beta, decider->beliefs()[arm].beta);
  }
}

TEST(EmbeddedDeciderExport, HasANewSourceIdInEachRunByDefault) {
  std::set<std::string> sources;
  for (int run = 0; run < 2; ++run) {
    const auto decider = MakeDecider();
    Game game({30, 60, 15});
    game.RunFor(*decider, 20'000);
    for (const PriorRecord& record : RecordsOf(decider->ExportPriors())) {
      sources.insert(record.source_id);
    }
  }
  EXPECT_EQ(sources.size(), 2U);
}

TEST_F(EmbeddedDeciderPriors, OfAFileAndATextAreMerged) {
  Write({RecordOf("SAP", 1, "a"), RecordOf("SAP", 1, "b")});
  std::vector<PriorRecord> saved = {RecordOf("SAP", 1, "b"), RecordOf("DBVT", 1, "c")};
  saved[0].source_sequence = 2;
  saved[0].evidence.alpha = 100;
  EmbeddedOptions options = Options();
  options.priors_data = FormatPriors(saved);
  const auto decider = MakeDecider(options);
  EXPECT_EQ(decider->prior_source_count(), 3U);
  EXPECT_EQ(decider->beliefs()[0].alpha, 1 + 10 + 100);
  EXPECT_EQ(decider->beliefs()[1].alpha, 11);
  EXPECT_EQ(RecordsOf(decider->ExportPriors()).size(), 3U);
}

TEST(EmbeddedDeciderIntervals, DefaultToThoseOfTheDecisionCore) {
  const decision::DecisionOptions core;
  const EmbeddedOptions options;
  EXPECT_EQ(options.decision_interval_ns, static_cast<uint64_t>(core.decision_interval_ns));
  EXPECT_EQ(options.cooldown_ns, static_cast<uint64_t>(core.cooldown_ns));
  EXPECT_EQ(options.settling_ns, static_cast<uint64_t>(core.settling_ns));
  EXPECT_EQ(options.fps_floor, core.fps_floor);
}

// Runs the policy `paper` for 400 s; it explores the three arms in the first 20 s.
size_t SwitchesAfterExploration(uint64_t cooldown_ns) {
  EmbeddedOptions options = PaperOptions();
  options.cooldown_ns = cooldown_ns;
  const auto decider = MakeDecider(options);
  Game game({20, 20, 20});
  game.RunFor(*decider, 400'000);
  return std::count_if(game.commands.begin(), game.commands.end(),
                       [](const auto& command) { return command.reason == SwitchReason::kPolicy; });
}

TEST(EmbeddedDeciderIntervals, AShortCooldownSwitchesOftenAndALongOneNever) {
  EXPECT_GT(SwitchesAfterExploration(4'000 * kMs), 20U);
  EXPECT_LE(SwitchesAfterExploration(40'000 * kMs), 10U);
  EXPECT_EQ(SwitchesAfterExploration(4'000'000 * kMs), 0U);
}

TEST(EmbeddedDeciderIntervals, SetTheNumberOfDecisions) {
  EmbeddedOptions options = PaperOptions();
  options.decision_interval_ns = 500 * kMs;
  const auto decider = MakeDecider(options);
  Game game({20, 20, 20});
  game.RunFor(*decider, 60'000);
  EXPECT_NEAR(static_cast<double>(decider->decision_count()), 120, 2);
}

TEST(EmbeddedDeciderIntervals, TheFrameRateFloorCanBeLowered) {
  for (const double fps_floor : {30.0, 10.0}) {
    EmbeddedOptions options = PaperOptions();
    options.fps_floor = fps_floor;
    const auto decider = MakeDecider(options);
    Game game({50, 50, 50});
    game.RunFor(*decider, 100'000);
    EXPECT_EQ(decider->verdict().verdict == Verdict::kDegraded, fps_floor == 30) << fps_floor;
  }
}

TEST(EmbeddedDeciderCreate, ErrorsNameTheInvalidOption) {
  const auto status = [](auto change) {
    EmbeddedOptions options;
    change(options);
    return EmbeddedDecider::Create(options, kArms, kVersions, 0).status();
  };
  EXPECT_EQ(status([](auto& o) { o.priors_file = "no/such/file"; }).code(), StatusCode::kNotFound);
  EXPECT_EQ(status([](auto& o) { o.time_scale = 0; }).code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status([](auto& o) { o.decision_interval_ns = 0; }).message(),
              HasSubstr("decision_interval_ns"));
  EXPECT_THAT(status([](auto& o) { o.cooldown_ns = ~0ULL, o.time_scale = 1000; }).message(),
              HasSubstr("cooldown_ns"));
  EXPECT_THAT(status([](auto& o) { o.settling_ns = ~uint64_t{0}; }).message(),
              HasSubstr("settling_ns"));
  EXPECT_THAT(status([](auto& o) { o.fps_floor = 1001; }).message(), HasSubstr("fps_floor"));
  const Status data = status([](auto& o) { o.priors_data = "{"; });
  EXPECT_EQ(data.code(), StatusCode::kDataLoss);
  EXPECT_THAT(data.message(), HasSubstr("priors_data: "));
  EXPECT_EQ(status([](auto& o) { o.source_id = "a\n"; }).code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status([](auto& o) { o.source_id = "*a"; }).message(), HasSubstr("begin with *"));
  EXPECT_EQ(status([](auto& o) { o.scene = ""; }).code(), StatusCode::kInvalidArgument);
  const Status policy = status([](auto& o) { o.policy = "dice"; });
  EXPECT_EQ(policy.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(policy.message(), HasSubstr("paper"));
  EXPECT_EQ(EmbeddedDecider::Create({}, {}, {}, 0).status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(EmbeddedDecider::Create({}, kArms, std::vector<uint32_t>{1}, 0).status().code(),
            StatusCode::kInvalidArgument);
}

TEST(EmbeddedDeciderCreate, RefusesAblationsOfTheLaboratory) {
  EmbeddedOptions options;
  options.policy = "adaptive-without-shadow";
  const Status status = EmbeddedDecider::Create(options, kArms, kVersions, 0).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("unknown policy"));
  EXPECT_THAT(status.message(), HasSubstr("adaptive, default, paper"));
  EXPECT_THAT(status.message(), testing::Not(HasSubstr("adaptive-without-gate")));
}

}  // namespace
}  // namespace sweepstake
