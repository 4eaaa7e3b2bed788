// Replays a whole run bit for bit: the exploration and 16 minutes of seven arms with scripted
// costs. The run includes bail-outs, a stall that detection does not explain, a changed object
// count, a pause, and a period in manual mode.
//
// golden/whole_run.log has one line per decision of the policy `paper`, with numbers as hexadecimal
// floats. golden/baselines.log has one line per baseline. After a change that is meant to change
// decisions, run this program once with SWEEPSTAKE_UPDATE_GOLDEN=1 in the environment to update
// them.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>

#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/hash.h"
#include "engine_client/math/random.h"
#include "tests/engine_client/decider/scripted_client.h"
#include "tests/laboratory/policies/study_policies.h"
#include "tests/support/file_text.h"

namespace sweepstake::decision {
namespace {

constexpr int64_t kRunTime = 16 * 60 * kSecond;

std::string Hex(double value) {
  std::array<char, 40> text;
  const auto end = std::to_chars(text.begin(), text.end(), value, std::chars_format::hex);
  return {text.data(), end.ptr};
}

uint64_t HashOf(std::string_view bytes) { return math::Fnv1a(math::kFnv1aStart, bytes); }

// Returns a hash of the draws' bits, little-endian.
uint64_t HashOf(const std::vector<double>& draws) {
  std::string bytes;
  for (const double draw : draws) {
    const auto bits = std::bit_cast<uint64_t>(draw);
    for (int shift = 0; shift < 64; shift += 8) bytes += static_cast<char>((bits >> shift) & 0xff);
  }
  return HashOf(bytes);
}

std::string LineOf(const Decision& decision) {
  const DecisionRecord& record = decision.record;
  std::ostringstream line;
  line << record.decision_id << ' ' << record.time_ns << " active=" << record.active_arm
       << " outcome=" << static_cast<uint32_t>(record.outcome);
  if (record.candidate)
    line << " candidate=" << *record.candidate << " draws=" << std::hex << HashOf(record.draws)
         << std::dec;
  if (record.reward) line << " reward=" << Hex(*record.reward);
  if (decision.increment) {
    const BetaPosterior& learnt = record.posteriors[decision.increment->arm];
    line << " posterior=" << decision.increment->arm << ':' << Hex(learnt.alpha) << ','
         << Hex(learnt.beta);
  }
  if (decision.command) {
    line << " command=" << decision.command->command_id << ':' << decision.command->arm << ':'
         << static_cast<uint32_t>(decision.command->reason);
  }
  return line.str();
}

// A game with scripted costs. As clients do, it reports a switch after the arm has settled.
class ScriptedGame {
 public:
  explicit ScriptedGame(std::string_view policy = "paper")
      : session_(Setup(policy), ComparedPolicies()) {}

  std::string Run() {
    while (now_ns_ < kRunTime) Step();
    for (const BetaPosterior& posterior : session_.posteriors()) {
      log_ << "final " << Hex(posterior.alpha) << ' ' << Hex(posterior.beta) << '\n';
    }
    return log_.str();
  }

  const DecisionSession& session() const { return session_; }
  int64_t now_ns() const { return now_ns_; }

 private:
  static SessionSetup Setup(std::string_view policy) {
    SessionSetup setup;
    setup.arms = {"BruteForce", "Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree"};
    setup.seed = 20260101;
    setup.options.policy = policy;
    return setup;
  }

  void Step() {
    ChangeMode();
    ExecuteCommand();
    const FrameSample frame = NextFrame();
    now_ns_ += static_cast<int64_t>(frame.frame_time_ns);
    session_.ObserveFrames({&frame, 1});
    session_.ObserveDescriptor(DescriptorOf(frame));
    if (frame.frame_time_ns > 5'000'000'000) Take(session_.ObserveBailOut(frame, now_ns_));
    ReportSwitch(frame);
    if (now_ns_ >= session_.next_tick_ns()) Take(session_.Tick(now_ns_));
  }

  void ChangeMode() {
    const bool manual = now_ns_ > 500 * kSecond && now_ns_ < 530 * kSecond;
    const Mode mode = manual ? Mode::kManual : Mode::kAi;
    if (session_.mode() != mode) session_.SetMode(mode, arm_, now_ns_);
  }

  void ExecuteCommand() {
    if (!command_) return;
    arm_ = command_->arm;
    ++epoch_;
    frames_in_epoch_ = 0;
    settled_ns_ = 0;
    reported_ = false;
    reason_ = command_->reason;
    command_.reset();
  }

  void ReportSwitch(const FrameSample& frame) {
    settled_ns_ += frame.frame_time_ns;
    if (reported_ || settled_ns_ < 2'000'000'000) return;
    session_.ObserveSwitch(arm_, epoch_, reason_, now_ns_);
    reported_ = true;
  }

  FrameSample NextFrame() {
    constexpr std::array<uint64_t, 7> kDetectionNs = {60'000'000, 9'000'000, 3'000'000, 2'500'000,
                                                      4'000'000,  5'000'000, 2'800'000};
    constexpr std::array<uint64_t, 7> kBytes = {1 << 20, 24 << 20, 2 << 20, 2 << 20,
                                                5 << 20, 9 << 20,  6 << 20};
    constexpr std::array<uint64_t, 7> kChecks = {1'999'000, 60'000, 250'000, 200'000,
                                                 40'000,    50'000, 30'000};
    FrameSample frame{.aabb_check_count = Noisy(kChecks[arm_]), .native_bytes = kBytes[arm_]};
    frame.object_count = now_ns_ < 300 * kSecond ? 2'000 : 2'200;
    frame.arm = arm_;
    frame.switch_epoch = epoch_;
    const bool count_changed = last_object_count_ != frame.object_count;
    last_object_count_ = frame.object_count;
    if (frames_in_epoch_++ == 0 || count_changed) frame.flags |= kFrameRebuild;
    if (now_ns_ > 700 * kSecond && now_ns_ < 705 * kSecond) frame.flags |= kFramePaused;
    // In the second half the tree is faster than the sweep.
    const uint64_t shift = now_ns_ > 480 * kSecond && arm_ == 3 ? 4'000'000 : 0;
    frame.detection_time_ns =
        Noisy(kDetectionNs[arm_] + shift) * ((frame.flags & kFrameRebuild) != 0 ? 6 : 1);
    if (arm_ == 0 && frames_in_epoch_ == 40) frame.detection_time_ns = 5'400'000'000;
    frame.frame_time_ns = 9'000'000 + frame.detection_time_ns;
    if (!stalled_ && now_ns_ > 400 * kSecond) {
      stalled_ = true;
      frame.frame_time_ns = 6'000'000'000;  // for example because of a disk access
    }
    return frame;
  }

  // The scene becomes denser until the tree is the fastest.
  SceneDescriptor DescriptorOf(const FrameSample& frame) const {
    SceneDescriptor descriptor;
    descriptor.object_count = static_cast<float>(frame.object_count);
    descriptor.density_ratio = static_cast<float>(now_ns_ / kSecond) * 0x1p-10F;
    descriptor.speed_mean = 0.25;
    return descriptor;
  }

  uint64_t Noisy(uint64_t value) {
    return value - value / 8 + value / 4 * noise_.NextBelow(1'024) / 1'024;
  }

  void Take(const Decision& decision) {
    log_ << LineOf(decision) << '\n';
    if (decision.command) command_ = decision.command;
  }

  DecisionSession session_;
  RandomStream noise_{99, RandomPurpose::kChoice, 0, 0};
  std::ostringstream log_;
  int64_t now_ns_ = 0;
  uint32_t arm_ = 0;
  uint32_t epoch_ = 0;
  uint32_t last_object_count_ = 2'000;
  uint64_t frames_in_epoch_ = 0;
  uint64_t settled_ns_ = 0;
  bool reported_ = true;
  bool stalled_ = false;
  SwitchReason reason_ = SwitchReason::kPolicy;
  std::optional<SwitchCommand> command_;
};

// Returns the first line in which the texts differ, with both versions.
std::string FirstDifference(const std::string& expected, const std::string& actual) {
  std::istringstream a(expected);
  std::istringstream b(actual);
  std::string line_a;
  std::string line_b;
  for (int number = 1; std::getline(a, line_a) && std::getline(b, line_b); ++number) {
    if (line_a == line_b) continue;
    std::ostringstream text;
    text << "line " << number << ":\n" << line_a << '\n' << line_b;
    return text.str();
  }
  return "one log is longer than the other";
}

void ExpectGolden(const std::string& file, const std::string& actual) {
  const std::filesystem::path path = std::filesystem::path(SWEEPSTAKE_GOLDEN_DIR) / file;
  if (const char* update = std::getenv("SWEEPSTAKE_UPDATE_GOLDEN");
      update && std::string_view(update) == "1") {
    std::ofstream(path, std::ios::binary) << actual;
  }
  const std::string expected = test_support::FileText(path);
  EXPECT_TRUE(expected == actual) << FirstDifference(expected, actual);
}

TEST(GoldenLog, OfAWholeRunReplaysBitForBit) {
  ExpectGolden("whole_run.log", ScriptedGame().Run());
}

// The file has one line per policy: the number of decisions of the same run, and a hash of the
// run's log.
TEST(GoldenLog, OfEveryBaselineReplaysBitForBit) {
  std::ostringstream lines;
  for (const char* policy : {"paper-one-draw", "random", "thresholds", "ucb1", "epsilon-greedy",
                             "discounted-ts", "lin-ts"}) {
    ScriptedGame game(policy);
    const std::string log = game.Run();
    lines << policy << ' ' << game.session().decision_count() << ' ' << std::hex << HashOf(log)
          << std::dec << '\n';
  }
  ExpectGolden("baselines.log", lines.str());
}

TEST(GoldenLog, ContainsEveryKindOfEvent) {
  ScriptedGame game;
  const std::string log = game.Run();
  for (const char* outcome : {"=1", "=2", "=3", "=4", "=5", "=6", "=7"}) {
    EXPECT_NE(log.find("outcome" + std::string(outcome)), std::string::npos) << outcome;
  }
  const ObservationSummary summary = game.session().observation(game.now_ns());
  EXPECT_TRUE(summary.start_ns);
  EXPECT_GE(summary.switch_count(SwitchReason::kPolicy), 5u);
  EXPECT_GE(game.session().counts().charged_bail_out_count, 2u);
  EXPECT_GT(game.session().counts().costless_frame_count, 0u);
}

}  // namespace
}  // namespace sweepstake::decision
