#include "server/watch/watch_hub.h"

#include <algorithm>
#include <random>
#include <utility>

#include "server/sessions/common/unix_time.h"

namespace sweepstake::watch {
namespace {

using priors::KeyedEvidence;
using priors::SceneEvidence;
using priors::SceneKey;

void Advance(SceneEvidence& scene, std::span<const KeyedEvidence> increments, bool new_source) {
  const auto unix_now_s = static_cast<uint64_t>(priors::UnixNowS());
  for (const auto& [key, evidence] : increments) {
    SceneEvidence::Arm& arm = scene.ArmOf(key.arm, key.backend_version);
    arm.of(key.measured_by) += evidence;
    arm.last_seen_unix_s = std::max(arm.last_seen_unix_s, unix_now_s);
  }
  if (new_source) ++scene.source_count;
}

}  // namespace

WatchHub::WatchHub(priors::AsyncPriorStore& store, Loop loop)
    : store_(store),
      loop_(std::move(loop)),
      boot_(uint64_t{std::random_device()()} << 32 | std::random_device()()) {}

EventStamp WatchHub::NextStamp() {
  return {.boot = boot_, .sequence = ++last_sequence_, .unix_ms = priors::UnixNowMs()};
}

void WatchHub::OnSession(const std::string& session_id, const sessions::SessionChange& change) {
  if (draining_ || std::none_of(session_listeners_.begin(), session_listeners_.end(),
                                [](const auto* listener) { return listener->WatchesSessions(); }))
    return;
  sessions_.insert_or_assign(session_id, change);
  ScheduleTick();
}

bool WatchHub::Watches(const SceneKey& scene) const {
  return std::any_of(listeners_.begin(), listeners_.end(),
                     [&](auto* listener) { return listener->Watches(scene); });
}

void WatchHub::OnDecision(const sessions::DecisionEvent& event) {
  for (WatchListener* listener : listeners_) {
    if (listener->Watches(event.session.scene)) listener->OnDecision(event);
  }
  if (!draining_) ScheduleTick();
}

void WatchHub::OnEvidence(const SceneKey& key, std::span<const KeyedEvidence> increments,
                          bool new_source) {
  if (draining_) return;
  if (!Watches(key)) {
    scenes_.erase(key);
    return;
  }
  const auto [found, unknown] = scenes_.try_emplace(key);
  Scene& scene = found->second;
  scene.changed = true;
  if (unknown) return Load(key);
  // What is being read has these increments already: the store has committed them before.
  if (!scene.sums) return;
  Advance(*scene.sums, increments, new_source);
  ScheduleTick();
}

// It is exact, and so no read: the job runs on the thread that commits, and its result takes the
// same way to the loop as the news of a commit. So the sums have exactly the increments that were
// told before.
void WatchHub::Load(const SceneKey& key) {
  const bool submitted = store_.Submit([this, key](priors::PriorStore& store) {
    loop_.post([this, key, loaded = store.LoadScene(key)] { OnLoaded(key, loaded); });
  });
  if (!submitted) LoadLater(scenes_.at(key));  // the store's queue is full
}

void WatchHub::LoadLater(Scene& scene) {
  scene.unread = true;
  ScheduleTick();
}

void WatchHub::Reload(const SceneKey& key) {
  if (draining_ || !Watches(key)) return Forget(key);
  scenes_.try_emplace(key);
  Load(key);
}

void WatchHub::OnLoaded(const SceneKey& key,
                        const absl::StatusOr<std::optional<SceneEvidence>>& loaded) {
  const auto found = scenes_.find(key);
  if (found == scenes_.end()) return;
  if (absl::IsUnavailable(loaded.status())) return LoadLater(found->second);
  // What is damaged is not read again and again, but at the scene's next evidence.
  if (!loaded.ok() || !loaded->has_value()) {
    scenes_.erase(found);
    return;
  }
  found->second.sums = *loaded;
  found->second.changed = true;
  ScheduleTick();
}

void WatchHub::ScheduleTick() {
  if (std::exchange(tick_scheduled_, true)) return;
  loop_.post_after(kIntervalNs, [this] { Tick(); });
}

void WatchHub::Tick() {
  tick_scheduled_ = false;
  TellSessions();
  for (WatchListener* listener : listeners_) listener->OnTick();
  LoadUnread();
  for (auto& [key, scene] : scenes_) {
    if (!scene.sums || !std::exchange(scene.changed, false)) continue;
    for (WatchListener* listener : listeners_) {
      if (listener->Watches(key)) listener->OnPosterior(*scene.sums);
    }
  }
  if (scenes_.size() <= kMaxScenes) return;
  std::erase_if(scenes_, [](const auto& entry) { return !entry.second.changed; });
}

void WatchHub::LoadUnread() {
  std::erase_if(scenes_,
                [this](const auto& entry) { return entry.second.unread && !Watches(entry.first); });
  size_t read_count = 0;
  for (auto& [key, scene] : scenes_) {
    if (!scene.unread) continue;
    if (++read_count > kReadsPerTick) return ScheduleTick();
    scene.unread = false;
    Load(key);
  }
}

void WatchHub::TellSessions() {
  const SessionChanges changes = std::exchange(sessions_, {});
  if (changes.empty()) return;
  for (SessionListener* listener : session_listeners_) listener->OnSessions(changes);
}

void WatchHub::Reset() {
  scenes_.clear();
  for (WatchListener* listener : listeners_) listener->OnReset();
}

void WatchHub::Drain() {
  draining_ = true;
  scenes_.clear();
  sessions_.clear();
}

}  // namespace sweepstake::watch
