#include "server/decision/audit_runs.h"

#include <cmath>
#include <tuple>

#include "server/decision/audit_text.h"

namespace sweepstake::decision {
namespace {

template <typename T>
bool IsSum(const T& value) {
  if constexpr (std::is_same_v<T, double>) {
    return value >= 0 && std::isfinite(value);
  } else {
    return true;
  }
}

std::optional<ArmRun> ParseRun(std::string_view text, uint32_t arm_count) {
  ArmRun run(0, 0, 0);
  const auto fields = ArmRun::Fields(run);
  const bool is_run = ParseText(text, fields) && run.arm() < arm_count &&
                      std::apply([](const auto&... each) { return (IsSum(each) && ...); }, fields);
  return is_run ? std::optional(run) : std::nullopt;
}

}  // namespace

void AppendRuns(std::string& out, const ArmRuns& runs) {
  const auto& [active, later, active_frames_seen] = ArmRuns::Fields(runs);
  AppendText(out, active_frames_seen);
  AppendText(out += ' ', ArmRun::Fields(active));
  if (later) AppendText(out += ' ', ArmRun::Fields(*later));
}

std::optional<ArmRuns> ParseRuns(std::string_view text, uint32_t arm_count) {
  bool seen = false;
  if (!ParseText(TakeItem(text, ' '), seen)) return std::nullopt;
  const auto parsed = ParseRun(TakeItem(text, ' '), arm_count);
  if (!parsed) return std::nullopt;
  ArmRuns runs(arm_count, *parsed);
  auto&& [active, later, active_frames_seen] = ArmRuns::Fields(runs);
  active_frames_seen = seen;
  if (text.empty()) return runs;
  later = ParseRun(text, arm_count);
  return later ? std::optional(runs) : std::nullopt;
}

}  // namespace sweepstake::decision
