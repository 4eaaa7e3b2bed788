#include "engine_client/telemetry/common/flight_recorder.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "engine_client/scene/aabbs_format.h"
#include "engine_client/scene/utf8_path.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

namespace fs = std::filesystem;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

size_t MaxBoxes(const FlightRecorderOptions& options) {
  return (size_t{options.memory_mb} << 20) / sizeof(Aabb);
}

uint64_t BudgetNs(const FlightRecorderOptions& options) {
  return static_cast<uint64_t>(options.frame_budget_ms * 1e6);
}

// The frames of a frozen ring that have boxes, as a scene that can be written to a file. The file
// format does not allow coordinates that are not finite. So a box with such a coordinate is
// replaced by an inverted box, which overlaps nothing either.
class FlightScene final : public Scene {
 public:
  FlightScene(std::string name, const FlightRing& ring, const std::vector<FlightFrame>& frames)
      : name_(std::move(name)), ring_(ring) {
    for (const FlightFrame& frame : frames) {
      if (frame.box_count > 0) shown_.push_back(&frame);
    }
    NoteWorld();
    if (!shown_.empty()) Show();
  }

  size_t frame_count() const { return shown_.size(); }
  std::string_view name() const override { return name_; }
  Aabb world() const override { return world_; }
  uint64_t frame_index() const override { return frame_index_; }
  std::span<const Aabb> aabbs() const override { return boxes_; }
  void DoStep() override {
    ++frame_index_;
    Show();
  }

 private:
  Aabb BoxOf(const FlightFrame& frame, uint32_t index) const {
    const Aabb& box = ring_.BoxOf(frame, index);
    return aabbs::IsFinite(box) ? box : Aabb{{1, 1, 1}, {-1, -1, -1}};
  }

  void Show() {
    const FlightFrame& frame = *shown_[frame_index_ % shown_.size()];
    boxes_.clear();
    for (uint32_t index = 0; index < frame.box_count; ++index)
      boxes_.push_back(BoxOf(frame, index));
  }

  // Sets the scene's world to the bounds of all valid boxes in the first and the last frame.
  void NoteWorld() {
    Aabb bounds{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (const FlightFrame* frame : shown_) {
      if (frame != shown_.front() && frame != shown_.back()) continue;
      for (uint32_t index = 0; index < frame->box_count; ++index) {
        const Aabb box = BoxOf(*frame, index);
        if (!IsValid(box)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          bounds.min[axis] = std::min(bounds.min[axis], box.min[axis]);
          bounds.max[axis] = std::max(bounds.max[axis], box.max[axis]);
        }
      }
    }
    if (aabbs::IsFinite(bounds)) world_ = bounds;
  }

  const std::string name_;
  const FlightRing& ring_;
  std::vector<const FlightFrame*> shown_;
  std::vector<Aabb> boxes_;
  Aabb world_{};
  uint64_t frame_index_ = 0;
};

size_t WorstOf(const std::vector<FlightFrame>& frames) {
  const auto worst = std::max_element(frames.begin(), frames.end(),
                                      [](const FlightFrame& a, const FlightFrame& b) {
                                        return a.sample.frame_time_ns < b.sample.frame_time_ns;
                                      });
  return static_cast<size_t>(worst - frames.begin());
}

// Returns the UTC time as text, such as "20261123-234641-250".
std::string TimeName(std::chrono::milliseconds since_epoch) {
  using std::chrono::floor;
  const std::chrono::sys_time<std::chrono::milliseconds> time(since_epoch);
  const auto day = floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  char text[64];
  std::snprintf(text, sizeof text, "%04d%02u%02u-%02d%02d%02d-%03d", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()),
                static_cast<int>(clock.subseconds().count()));
  return text;
}

// Returns a path in the folder at which no file exists yet.
fs::path FreePath(const fs::path& folder, std::chrono::milliseconds now) {
  std::error_code error;
  fs::path path;
  do {
    path = folder / ("flight-" + TimeName(now++) + ".aabbs");
  } while (fs::exists(path, error));
  return path;
}

std::string Utf8Of(const fs::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

}  // namespace

FlightRecorder::FlightRecorder(const SessionOptions& options)
    : options_(options),
      ring_(MaxBoxes(options.flight_recorder), BudgetNs(options.flight_recorder)) {}

void FlightRecorder::Step(const AdaptiveBroadPhase& adaptive) {
  NoteDecision(adaptive);
  if (!ring_.frozen()) return;
  const Status status = Write(adaptive);
  ring_.Release();
  const std::lock_guard lock(mutex_);
  error_ = status.ok() ? "" : status.message();
}

void FlightRecorder::NoteDecision(const AdaptiveBroadPhase& adaptive) {
  const std::optional<LastDecision> latest = adaptive.last_decision();
  if (!latest) return;
  if (!decisions_.empty() && decisions_.back().decision.time_ns == latest->time_ns) return;
  decisions_.push_back({ring_.latest_frame_index(), *latest});
  if (decisions_.size() > kMaxDecisions) decisions_.pop_front();
}

Status FlightRecorder::Write(const AdaptiveBroadPhase& adaptive) {
  const std::vector<FlightFrame> frames = ring_.Frames();
  FlightScene scene(options_.scene, ring_, frames);
  if (scene.frame_count() == 0) {
    return {StatusCode::kResourceExhausted,
            "a frame was over the budget, but the flight recorder's memory does not hold the boxes "
            "of two frames of " +
                std::to_string(frames.back().sample.object_count) +
                " objects; raise flight_recorder.memory_mb"};
  }
  const auto now = std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  const std::optional<fs::path> folder = PathOfUtf8(options_.flight_recorder.directory);
  const fs::path path = FreePath(*folder, now);
  const size_t worst = WorstOf(frames);
  const std::string notes = FlightNotes(options_, adaptive, frames, worst, decisions_, now.count());
  FlightRecording recording{.path = Utf8Of(path),
                            .recorded_unix_ms = now.count(),
                            .bytes = 0,
                            .worst_frame_ns = frames[worst].sample.frame_time_ns};
  if (Status status = RecordScene(scene, scene.frame_count() - 1, recording.path, notes);
      !status.ok()) {
    return status;
  }
  std::error_code error;
  recording.bytes = fs::file_size(path, error);
  return Keep(std::move(recording));
}

Status FlightRecorder::Keep(FlightRecording recording) {
  const std::lock_guard lock(mutex_);
  recordings_.push_back(std::move(recording));
  if (recordings_.size() <= kMaxRecordings) return {};
  const std::string oldest = recordings_.front().path;
  recordings_.erase(recordings_.begin());
  std::error_code error;
  fs::remove(*PathOfUtf8(oldest), error);
  if (!error) return {};
  return {StatusCode::kUnavailable, oldest + " cannot be removed: " + error.message()};
}

std::vector<FlightRecording> FlightRecorder::recordings() const {
  const std::lock_guard lock(mutex_);
  return recordings_;
}

std::string FlightRecorder::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

}  // namespace sweepstake
