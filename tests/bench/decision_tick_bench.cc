// What one decision costs: the time of DecisionSession::Tick, with a window and a shadow sweep of
// all arms to learn from, for a few and for the most arms there may be.
//
// Prints p50 and p99 in microseconds per policy and number of arms, then the same with an audit log
// and how long its rows are. The goal is p99 < 1 ms.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "server/audit/audit_log.h"
#include "server/decision/math/random.h"
#include "server/decision/session/decision_session.h"

namespace sweepstake::decision {
namespace {

constexpr int kTickCount = 5'000;
constexpr int kFramesPerTick = 20;

class RowMeter final : public AuditSink {
 public:
  void OnAuditRow(std::string_view row) override {
    ++row_count_;
    bytes_ += row.size();
  }
  double mean_bytes() const {
    return static_cast<double>(bytes_) / static_cast<double>(std::max<uint64_t>(row_count_, 1));
  }

 private:
  uint64_t row_count_ = 0;
  uint64_t bytes_ = 0;
};

class Game {
 public:
  // Without a sink there is no audit log.
  Game(const std::string& policy, uint32_t arm_count, AuditSink* sink)
      : session_(Setup(policy, arm_count)) {
    if (sink != nullptr) StartAudit(session_, *sink, {});
  }

  // Sorted, in microseconds.
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
      const Frame frame{.frame_time_ns = 100'000'000,
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
    const auto start = std::chrono::steady_clock::now();
    const Decision decision = session_.Tick(now_ns);
    const auto end = std::chrono::steady_clock::now();
    if (decision.command) {
      session_.ObserveSwitch(decision.command->arm, ++epoch_, decision.command->reason, now_ns);
    }
    return std::chrono::duration<double, std::micro>(end - start).count();
  }

  RandomStream random_{1, RandomPurpose::kChoice, 0, 0};
  DecisionSession session_;
  uint64_t sweep_ = 0;
  uint32_t epoch_ = 0;
};

}  // namespace
}  // namespace sweepstake::decision

int main() {
  using sweepstake::decision::Game;
  using sweepstake::decision::RowMeter;
  const auto quantile = [](const std::vector<double>& sorted, size_t percent) {
    return sorted[sorted.size() * percent / 100];
  };
  std::printf("%-10s %5s %10s %10s %14s %14s %10s\n", "policy", "arms", "p50 us", "p99 us",
              "audited p50 us", "audited p99 us", "row bytes");
  for (const char* policy : {"paper", "adaptive"}) {
    for (const uint32_t arm_count : {7u, 32u}) {
      RowMeter rows;
      const std::vector<double> plain = Game(policy, arm_count, nullptr).TickTimes();
      const std::vector<double> audited = Game(policy, arm_count, &rows).TickTimes();
      std::printf("%-10s %5u %10.1f %10.1f %14.1f %14.1f %10.0f\n", policy, arm_count,
                  quantile(plain, 50), quantile(plain, 99), quantile(audited, 50),
                  quantile(audited, 99), rows.mean_bytes());
    }
  }
}
