#include "server/history/history_point.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>

namespace sweepstake::history {

void ToProto(const sessions::LogHistogram& histogram, v1::LogHistogram& message) {
  uint32_t before = 0;
  for (const auto& [number, count] : histogram.buckets()) {
    message.add_bucket_steps(number - before);
    message.add_counts(count);
    before = number;
  }
}

namespace {

void AddCounts(const v1::LogHistogram& message, std::map<uint32_t, uint64_t>& counts) {
  uint32_t number = 0;
  for (int i = 0; i < message.bucket_steps_size(); ++i) {
    number += message.bucket_steps(i);
    counts[number] += message.counts(i);
  }
}

void Add(const v1::LogHistogram& added, v1::LogHistogram& sum) {
  std::map<uint32_t, uint64_t> counts;
  AddCounts(sum, counts);
  AddCounts(added, counts);
  while (counts.size() > sessions::LogHistogram::kMaxBuckets) {
    std::next(counts.begin())->second += counts.begin()->second;
    counts.erase(counts.begin());
  }
  uint64_t most = 0;
  for (const auto& [number, count] : counts) most = std::max(most, count);
  int halvings = 0;
  while (most >> halvings > std::numeric_limits<uint32_t>::max()) ++halvings;
  sum.Clear();
  uint32_t before = 0;
  for (const auto& [number, count] : counts) {
    sum.add_bucket_steps(number - before);
    sum.add_counts(static_cast<uint32_t>(count >> halvings));
    before = number;
  }
}

// Returns the arm of the point; adds it in the order of names if it is missing.
v1::ArmHistory& ArmOf(v1::HistoryPoint& point, const std::string& name) {
  auto& arms = *point.mutable_arms();
  const auto place =
      std::lower_bound(arms.begin(), arms.end(), name,
                       [](const v1::ArmHistory& arm, const auto& it) { return arm.arm() < it; });
  const int index = static_cast<int>(place - arms.begin());
  if (index < arms.size() && arms[index].arm() == name) return arms[index];
  arms.Add()->set_arm(name);
  for (int i = arms.size() - 1; i > index; --i) arms.SwapElements(i, i - 1);
  return arms[index];
}

}  // namespace

v1::HistoryPoint PointOf(const SessionReport& report) {
  const sessions::SessionUse& use = report.use;
  v1::HistoryPoint point;
  point.set_unix_ms(use.unix_start_ms);
  point.set_end_unix_ms(use.unix_end_ms);
  point.set_frame_count(use.measured.frame_count);
  point.set_ran_us(use.measured.ran_us);
  point.set_initial_us(use.measured.arm_us[use.initial_arm]);
  point.set_initial_known_frame_count(use.measured.known_frame_counts[use.initial_arm]);
  point.set_switch_count(use.switch_count);
  point.set_session_count(use.is_first ? 1 : 0);
  ToProto(use.frames.frame_time_ns, *point.mutable_frame_time_ns());
  ToProto(use.frames.detection_time_ns, *point.mutable_detection_time_ns());
  ToProto(use.frames.native_bytes, *point.mutable_native_bytes());
  for (size_t i = 0; i < report.arms.size(); ++i) {
    v1::ArmHistory& arm = ArmOf(point, report.arms[i]);
    arm.set_active_frame_count(use.active_frame_counts[i]);
    arm.set_frame_count(use.measured.frame_count);
    arm.set_would_take_us(use.measured.arm_us[i]);
    arm.set_known_frame_count(use.measured.known_frame_counts[i]);
  }
  return point;
}

std::vector<HistoryEntry> EntriesOf(const HistoryBatch& batch) {
  std::map<SeriesKey, v1::HistoryPoint> sums;
  for (const SessionReport& report : batch.reports) {
    const v1::HistoryPoint point = PointOf(report);
    SeriesKey key = {.kind = v1::HISTORY_KIND_SCENE, .scene = report.scene};
    Add(point, sums[key]);
    key.kind = v1::HISTORY_KIND_BUILD;
    key.build = report.build;
    Add(point, sums[key]);
    key.kind = v1::HISTORY_KIND_SESSION;
    key.session = report.session;
    Add(point, sums[key]);
  }
  for (auto& [key, sum] : sums) {
    const auto activity = batch.activities.find(key.scene);
    if (key.kind == v1::HISTORY_KIND_SCENE && activity != batch.activities.end())
      *sum.mutable_activity() = activity->second;
  }
  return {std::make_move_iterator(sums.begin()), std::make_move_iterator(sums.end())};
}

void Add(const v1::HistoryPoint& point, v1::HistoryPoint& sum) {
  const bool is_first = sum.end_unix_ms() == 0;
  if (point.has_activity() && point.end_unix_ms() >= sum.end_unix_ms())
    *sum.mutable_activity() = point.activity();
  sum.set_unix_ms(is_first ? point.unix_ms() : std::min(sum.unix_ms(), point.unix_ms()));
  sum.set_end_unix_ms(std::max(sum.end_unix_ms(), point.end_unix_ms()));
  sum.set_frame_count(sum.frame_count() + point.frame_count());
  sum.set_ran_us(sum.ran_us() + point.ran_us());
  sum.set_initial_us(sum.initial_us() + point.initial_us());
  sum.set_initial_known_frame_count(sum.initial_known_frame_count() +
                                    point.initial_known_frame_count());
  sum.set_switch_count(sum.switch_count() + point.switch_count());
  Add(point.frame_time_ns(), *sum.mutable_frame_time_ns());
  Add(point.detection_time_ns(), *sum.mutable_detection_time_ns());
  Add(point.native_bytes(), *sum.mutable_native_bytes());
  sum.set_session_count(sum.session_count() + point.session_count());
  for (const v1::ArmHistory& added : point.arms()) {
    v1::ArmHistory& arm = ArmOf(sum, added.arm());
    arm.set_active_frame_count(arm.active_frame_count() + added.active_frame_count());
    arm.set_frame_count(arm.frame_count() + added.frame_count());
    arm.set_would_take_us(arm.would_take_us() + added.would_take_us());
    arm.set_known_frame_count(arm.known_frame_count() + added.known_frame_count());
  }
}

}  // namespace sweepstake::history
