// Measures the cost of a decision: the time of DecisionSession::Tick with a window and a shadow
// sweep of all arms, for a few arms and for the maximum number.
//
// decision_tick_bench [--json] [POLICY…] (default: paper adaptive). Prints p50 and p99 per policy
// and number of arms, the same with an audit log, and the size of a row of the log. Every figure is
// the best of a few rounds, because other programs may use the machine. The goal is in
// tests/bench/data/goals.toml.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/random.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {
namespace {

constexpr int kRoundCount = 5;
constexpr int kTickCount = 1'000;  // ticks per round
constexpr int kFramesPerTick = 20;

// Returns the processor time of this thread, which excludes other programs, or a steady clock if
// the system has no such clock.
double NowUs() {
#ifdef __unix__
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e6 + static_cast<double>(time.tv_nsec) * 1e-3;
#else
  const auto time = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::micro>(time).count();
#endif
}

class NoLog final : public AuditSink {
 public:
  void OnAuditRow(const AuditRow&) override {}
};

class Game {
 public:
  // Without a sink there is no audit log.
  Game(const std::string& policy, uint32_t arm_count, AuditSink* sink)
      : session_(Setup(policy, arm_count), ComparedPolicies()) {
    if (sink != nullptr) StartAudit(session_, *sink, {});
  }

  // Returns the sorted times in microseconds.
  std::vector<double> TickTimes() {
    std::vector<double> times_us;
    for (int tick = 0; tick < kTickCount; ++tick) times_us.push_back(TimeTick());
    std::sort(times_us.begin(), times_us.end());
    return times_us;
  }

 private:
  static SessionSetup Setup(const std::string& policy, uint32_t arm_count) {
    SessionSetup setup;
    setup.options.policy = policy;
    for (uint32_t arm = 0; arm < arm_count; ++arm)
      setup.arms.push_back("arm" + std::to_string(arm));
    return setup;
  }

  double CostNs(uint32_t arm) {
    return 1e6 * (1 + 0.05 * arm) * std::exp(0.05 * DrawNormal(random_));
  }

  void RunFrames() {
    for (int i = 0; i < kFramesPerTick; ++i) {
      const FrameSample frame{
          .frame_time_ns = 100'000'000,
          .detection_time_ns = static_cast<uint64_t>(CostNs(session_.active_arm())),
          .aabb_check_count = 10'000,
          .native_bytes = 1 << 20,
          .object_count = 1'000,
          .arm = session_.active_arm(),
          .switch_epoch = epoch_};
      session_.ObserveFrames({&frame, 1});
    }
  }

  void Sweep() {
    ++sweep_;
    for (uint32_t arm = 0; arm < session_.arms().size(); ++arm) {
      const ShadowSample sample{.first_frame_index = sweep_,
                                .detection_time_ns = static_cast<uint64_t>(CostNs(arm)),
                                .arm = arm,
                                .object_count = 1'000,
                                .frame_count = 5};
      session_.ObserveShadow({&sample, 1});
    }
  }

  double TimeTick() {
    RunFrames();
    Sweep();
    const int64_t now_ns = session_.next_tick_ns();
    const double start_us = NowUs();
    const Decision decision = session_.Tick(now_ns);
    const double time_us = NowUs() - start_us;
    if (decision.command) {
      session_.ObserveSwitch(decision.command->arm, ++epoch_, decision.command->reason, now_ns);
    }
    return time_us;
  }

  RandomStream random_{1, RandomPurpose::kChoice, 0, 0};
  DecisionSession session_;
  uint64_t sweep_ = 0;
  uint32_t epoch_ = 0;
};

struct Quantiles {
  double p50_us = std::numeric_limits<double>::infinity();
  double p99_us = std::numeric_limits<double>::infinity();
};

Quantiles TimeTicks(const std::string& policy, uint32_t arm_count, AuditSink* sink) {
  Quantiles best;
  for (int round = 0; round < kRoundCount; ++round) {
    const std::vector<double> times_us = Game(policy, arm_count, sink).TickTimes();
    best.p50_us = std::min(best.p50_us, times_us[kTickCount * 50 / 100]);
    best.p99_us = std::min(best.p99_us, times_us[kTickCount * 99 / 100]);
  }
  return best;
}

struct Row {
  std::string policy;
  uint32_t arm_count = 0;
  Quantiles plain;
  Quantiles audited;
};

Row Measure(const std::string& policy, uint32_t arm_count) {
  NoLog rows;
  Row row{.policy = policy, .arm_count = arm_count, .plain = {}, .audited = {}};
  row.plain = TimeTicks(policy, arm_count, nullptr);
  row.audited = TimeTicks(policy, arm_count, &rows);
  return row;
}

void PrintTable(const std::vector<Row>& rows) {
  std::printf("%-10s %5s %10s %10s %14s %14s\n", "policy", "arms", "p50 us", "p99 us",
              "audited p50 us", "audited p99 us");
  for (const Row& row : rows) {
    std::printf("%-10s %5u %10.1f %10.1f %14.1f %14.1f\n", row.policy.c_str(), row.arm_count,
                row.plain.p50_us, row.plain.p99_us, row.audited.p50_us, row.audited.p99_us);
  }
}

void PrintJson(const std::vector<Row>& rows) {
  std::printf("{\"command\": \"decision_tick_bench\", \"rows\": [");
  for (const Row& row : rows) {
    std::printf(
        "%s\n  {\"policy\": \"%s\", \"arms\": %u, \"p50_ms\": %.6f, \"p99_ms\": %.6f, "
        "\"audited_p50_ms\": %.6f, \"audited_p99_ms\": %.6f}",
        &row == rows.data() ? "" : ",", row.policy.c_str(), row.arm_count, 1e-3 * row.plain.p50_us,
        1e-3 * row.plain.p99_us, 1e-3 * row.audited.p50_us, 1e-3 * row.audited.p99_us);
  }
  std::printf("\n]}\n");
}

int Run(std::vector<std::string> words) {
  const bool json = std::erase(words, "--json") > 0;
  if (words.empty()) words = {"paper", "adaptive"};
  std::vector<Row> rows;
  for (const std::string& policy : words) {
    DecisionOptions options;
    options.policy = policy;
    if (const auto error = Validate(options, ComparedPolicies())) {
      std::fprintf(stderr, "%s\n", error->c_str());
      return 2;
    }
    for (const uint32_t arm_count : {7u, uint32_t{kMaxArms}}) {
      rows.push_back(Measure(policy, arm_count));
    }
  }
  json ? PrintJson(rows) : PrintTable(rows);
  return 0;
}

}  // namespace
}  // namespace sweepstake::decision

int main(int argc, char** argv) {
  return sweepstake::decision::Run({argv + std::min(argc, 1), argv + argc});
}
