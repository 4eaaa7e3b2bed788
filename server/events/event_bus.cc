#include "server/events/event_bus.h"

#include <algorithm>
#include <random>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/sessions/common/reasons.h"
#include "server/sessions/common/unix_time.h"

namespace sweepstake::events {
namespace {

using priors::KeyedEvidence;
using priors::SceneEvidence;
using priors::SceneKey;
using sessions::Refused;

// Returns the key as one string. A newline separates the fields, because names have no control
// characters.
std::string TextOf(const SceneKey& key) {
  return absl::StrCat(key.project, "\n", key.scene, "\n", key.machine_class, "\n",
                      key.reward_version);
}

// The reverse of TextOf.
SceneKey KeyOf(const std::string& text) {
  const std::vector<std::string> names = absl::StrSplit(text, '\n');
  return {names[0], names[1], names[2], static_cast<uint32_t>(std::stoul(names[3]))};
}

void Advance(SceneEvidence& scene, std::span<const KeyedEvidence> increments, bool new_source) {
  const auto unix_now_s = static_cast<uint64_t>(priors::UnixNowS());
  for (const auto& [key, evidence] : increments) {
    SceneEvidence::Arm& arm = scene.ArmOf(key.arm, key.backend_version);
    arm.Add(key.regime, key.measured_by, evidence);
    arm.last_seen_unix_s = std::max(arm.last_seen_unix_s, unix_now_s);
  }
  if (new_source) ++scene.source_count;
}

std::shared_ptr<const std::string> Shared(std::string body) {
  return std::make_shared<const std::string>(std::move(body));
}

}  // namespace

// Receives the box views of one session and publishes them on the channel of its viewers.
class EventBus::BoxFeed final : public sessions::BoxViewListener {
 public:
  BoxFeed(EventBus& bus, Channel& channel, const std::shared_ptr<sessions::GameSession>& session)
      : bus_(bus), channel_(channel), session_(session) {}
  ~BoxFeed() override {
    if (const auto session = session_.lock()) session->boxes().Remove(*this);
  }
  BoxFeed(const BoxFeed&) = delete;
  BoxFeed& operator=(const BoxFeed&) = delete;

  void OnView(const std::string& view) override {
    Put(channel_, "", bus_.MakeEvent(Kind::kBoxes, Shared(bus_.encoder_.Boxes(view))));
    Wake(channel_);
  }
  void OnEnd(const absl::Status& status) override { bus_.EndAll(status, &channel_); }

 private:
  EventBus& bus_;
  Channel& channel_;
  const std::weak_ptr<sessions::GameSession> session_;
};

EventBus::EventBus(priors::AsyncPriorStore& store, sessions::DecisionLoop& loop,
                   const sessions::SessionTable& sessions, const Encoder& encoder)
    : store_(store),
      loop_(loop),
      sessions_(sessions),
      encoder_(encoder),
      boot_(uint64_t{std::random_device()()} << 32 | std::random_device()()) {}

void EventBus::Subscribe(Wish wish, Sink& sink) {
  auto subscriber = std::make_unique<Subscriber>(*this, std::move(wish), sink);
  Subscriber& begun = *subscriber;
  const absl::Status joined = Join(begun);
  if (!joined.ok()) return End(begun, joined);
  const ChannelPtr channel = begun.channel_;
  sink.Begin(std::move(subscriber));
  if (channel->complete || channel->load_count > 0) return sink.Wake();
  channel->load_count = 1;
  channel->kind == Kind::kPosteriors ? LoadScenes(channel, {}) : LoadSessions(channel, "");
}

absl::Status EventBus::Join(Subscriber& subscriber) {
  if (draining_)
    return Refused(sessions::reasons::kDraining, "the daemon is draining; watch again later");
  const Wish& wish = subscriber.wish_;
  if (wish.kind == Kind::kBoxes) {
    if (const absl::Status joined = JoinBoxes(subscriber); !joined.ok()) return joined;
  } else {
    ChannelPtr& channel = channels_[{wish.kind, wish.filter}];
    if (channel == nullptr)
      channel = std::make_shared<Channel>(Channel{.kind = wish.kind, .filter = wish.filter});
    subscriber.channel_ = channel;
  }
  subscriber.channel_->subscribers.push_back(&subscriber);
  subscribers_.insert(&subscriber);
  return absl::OkStatus();
}

absl::Status EventBus::JoinBoxes(Subscriber& subscriber) {
  const auto session = sessions_.Find(subscriber.wish_.session_id);
  if (session == nullptr || session->ended()) return sessions::UnknownSession();
  const SceneKey& scene = session->identity().scene;
  if (!subscriber.wish_.filter.Matches(scene.project, scene.scene))
    return sessions::UnknownSession();
  const auto channel = std::make_shared<Channel>(Channel{.kind = Kind::kBoxes, .complete = true});
  channel->boxes = std::make_unique<BoxFeed>(*this, *channel, session);
  subscriber.channel_ = channel;
  return session->boxes().Add(*channel->boxes);
}

void EventBus::Remove(Subscriber& subscriber) {
  subscribers_.erase(&subscriber);
  const ChannelPtr channel = std::move(subscriber.channel_);
  if (channel == nullptr) return;
  std::erase(channel->subscribers, &subscriber);
  if (channel->subscribers.empty() && channel->kind != Kind::kBoxes)
    channels_.erase({channel->kind, channel->filter});
}

void EventBus::End(Subscriber& subscriber, const absl::Status& status) {
  Sink& sink = subscriber.sink_;
  Remove(subscriber);
  subscriber.wish_.share.reset();
  if (subscriber.wish_.on_end) subscriber.wish_.on_end(status);
  sink.OnEnd(status);
}

void EventBus::EndAll(const absl::Status& status, const Channel* of) {
  for (Subscriber* subscriber : std::set<Subscriber*>(subscribers_)) {
    if (of == nullptr || subscriber->channel_.get() == of) End(*subscriber, status);
  }
}

void EventBus::EndRefused() {
  for (Subscriber* subscriber : std::set<Subscriber*>(subscribers_)) {
    if (!subscriber->wish_.check) continue;
    if (const absl::Status still = subscriber->wish_.check(); !still.ok()) End(*subscriber, still);
  }
}

void EventBus::LoadScenes(const ChannelPtr& channel, const std::optional<SceneKey>& after) {
  const bool submitted = store_.Read([this, weak = std::weak_ptr(channel), after,
                                      filter = channel->filter, load = channel->load_count,
                                      sequence = last_sequence_](priors::PriorReader& store) {
    if (weak.expired()) return;
    const auto scenes = store.List(filter, after, kPageSize);
    std::vector<PageScene> page;
    if (scenes.ok()) {
      for (const SceneEvidence& scene : *scenes)
        page.push_back({scene.key, Shared(encoder_.Scene(scene))});
    }
    loop_.Post([this, weak, load, sequence, status = scenes.status(), page = std::move(page)] {
      const ChannelPtr loaded = weak.lock();
      if (loaded == nullptr || loaded->load_count != load) return;
      if (status.ok()) return OnScenes(loaded, sequence, page);
      EndAll(sessions::WithReason(status, sessions::reasons::kStoreFailed.name), loaded.get());
    });
  });
  if (!submitted) {
    EndAll(
        Refused(sessions::reasons::kStoreBusy, "the prior store is overloaded; watch again later"),
        channel.get());
  }
}

void EventBus::OnScenes(const ChannelPtr& channel, uint64_t last_sequence,
                        const std::vector<PageScene>& page) {
  channel->complete = page.size() < kPageSize;
  for (const PageScene& scene : page) {
    const std::string key = TextOf(scene.key);
    const auto known = channel->state.find(key);
    // Keep an event that was published after the page was requested: it may be newer than the page.
    if (known == channel->state.end() || known->second->stamp.sequence <= last_sequence)
      Put(*channel, key, SceneEvent(scene.key, scene.body));
  }
  Wake(*channel);
  if (!channel->complete) LoadScenes(channel, page.back().key);
}

void EventBus::LoadSessions(const ChannelPtr& channel, const std::string& after) {
  const auto page = sessions_.List(channel->filter, after, kPageSize);
  channel->complete = page.size() < kPageSize;
  for (const sessions::SessionView& session : page)
    Put(*channel, session.id, MakeEvent(Kind::kSessions, Shared(encoder_.Session(session))));
  Wake(*channel);
  if (channel->complete) return;
  loop_.Post([this, weak = std::weak_ptr(channel), last = page.back().id] {
    if (const ChannelPtr loaded = weak.lock()) LoadSessions(loaded, last);
  });
}

EventStamp EventBus::NextStamp() {
  return {.boot = boot_, .sequence = ++last_sequence_, .unix_ms = priors::UnixNowMs()};
}

EventPtr EventBus::MakeEvent(Kind kind, std::shared_ptr<const std::string> body) {
  const EventStamp stamp = NextStamp();
  return std::make_shared<Event>(
      Event{.stamp = stamp, .body = std::move(body), .tail = encoder_.Stamp(kind, stamp)});
}

EventPtr EventBus::SceneEvent(const SceneKey& key, std::shared_ptr<const std::string> body) {
  const EventStamp stamp = NextStamp();
  const sessions::SceneActivity activity = sessions_.ActivityOf(key);
  return std::make_shared<Event>(
      Event{.stamp = stamp,
            .body = std::move(body),
            .tail = encoder_.Activity(activity) + encoder_.Stamp(Kind::kPosteriors, stamp),
            .run = activity.run});
}

template <typename Use>
void EventBus::ForEachChannel(Kind kind, const SceneKey& scene, Use use) const {
  for (const auto& [key, channel] : channels_) {
    if (key.first == kind && channel->filter.Matches(scene.project, scene.scene)) use(*channel);
  }
}

void EventBus::Put(Channel& channel, const std::string& key, const EventPtr& event) {
  channel.state[key] = event;
  for (Subscriber* subscriber : channel.subscribers) subscriber->Put(key, event);
}

void EventBus::Wake(const Channel& channel) {
  for (Subscriber* subscriber : channel.subscribers) subscriber->sink_.Wake();
}

EventPtr EventBus::EmptyScene(const std::string& key) {
  const SceneKey scene = KeyOf(key);
  return SceneEvent(scene, Shared(encoder_.Scene({.key = scene, .arms = {}})));
}

EventPtr EventBus::Refreshed(const Channel& channel, const std::string& key,
                             const EventPtr& event) {
  if (channel.kind == Kind::kPosteriors) return SceneEvent(KeyOf(key), event->body);
  const auto session = sessions_.Describe(key);
  return session ? MakeEvent(Kind::kSessions, Shared(encoder_.Session(*session))) : nullptr;
}

bool EventBus::Watches(const SceneKey& scene) const {
  bool watches = false;
  ForEachChannel(Kind::kPosteriors, scene, [&](const Channel&) { watches = true; });
  return watches;
}

void EventBus::OnSession(const std::string& session_id, const sessions::SessionChange& change) {
  bool watches = false;
  ForEachChannel(Kind::kSessions, change.scene, [&](const Channel&) { watches = true; });
  if (watches) changed_sessions_.insert_or_assign(session_id, change);
  const bool watches_scene = Watches(change.scene);
  if (watches_scene) session_scenes_.insert(change.scene);
  if (watches || watches_scene) ScheduleTick();
}

void EventBus::OnDecision(const sessions::SessionDecision& event) {
  const SceneKey& scene = event.session.scene;
  if (!Watches(scene)) return;
  Decisions& decisions = decisions_[scene];
  decisions.body += encoder_.Decision(event);
  if (++decisions.count == kDecisionsPerMessage)
    PublishDecisions(scene, std::exchange(decisions, {}));
  ScheduleTick();
}

void EventBus::OnEvidence(const SceneKey& key, std::span<const KeyedEvidence> increments,
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
  // While the sums are being read, there is nothing to add. The result will contain these
  // increments, because it is posted to the loop after the report of their commit.
  if (!scene.sums) return;
  Advance(*scene.sums, increments, new_source);
  ScheduleTick();
}

// Reads the sums on the store's writing thread, which also commits. Results and reports of commits
// reach the loop in the same order. The sums therefore contain exactly the increments that were
// reported before them.
void EventBus::Load(const SceneKey& key) {
  const bool submitted = store_.Submit([this, key](priors::PriorStore& store) {
    loop_.PostLater([this, key, loaded = store.LoadScene(key)] { OnLoaded(key, loaded); });
  });
  if (!submitted) LoadLater(scenes_.at(key));  // the store's queue is full
}

void EventBus::LoadLater(Scene& scene) {
  scene.unread = true;
  ScheduleTick();
}

void EventBus::Reload(const SceneKey& key) {
  if (draining_ || !Watches(key)) {
    scenes_.erase(key);
    return;
  }
  scenes_[key].sums.reset();
  Load(key);
}

void EventBus::OnLoaded(const SceneKey& key,
                        const absl::StatusOr<std::optional<SceneEvidence>>& loaded) {
  const auto found = scenes_.find(key);
  if (found == scenes_.end()) return;
  if (absl::IsUnavailable(loaded.status())) return LoadLater(found->second);
  // The scene is damaged or not stored. It is read again when its next evidence is committed.
  if (!loaded.ok() || !loaded->has_value()) {
    scenes_.erase(found);
    // Another daemon of the store has revoked all evidence of a scene that watchers have.
    if (loaded.ok() && IsPublished(key)) Reset();
    return;
  }
  found->second.sums = *loaded;
  found->second.changed = true;
  ScheduleTick();
}

bool EventBus::IsPublished(const SceneKey& key) const {
  return std::any_of(channels_.begin(), channels_.end(), [&](const auto& entry) {
    const Channel& channel = *entry.second;
    return channel.kind == Kind::kPosteriors && channel.state.contains(TextOf(key));
  });
}

void EventBus::ScheduleTick() {
  if (draining_ || std::exchange(tick_scheduled_, true)) return;
  loop_.PostAt(loop_.clock().NowNs() + kIntervalNs, [this] { Tick(); });
}

void EventBus::Tick() {
  tick_scheduled_ = false;
  PublishSessions();
  for (auto& [scene, decisions] : std::exchange(decisions_, {}))
    PublishDecisions(scene, std::move(decisions));
  LoadUnread();
  for (auto& [key, scene] : scenes_) {
    if (scene.sums && std::exchange(scene.changed, false) && Watches(key))
      PublishScene(*scene.sums);
  }
  PublishRuns();
  if (scenes_.size() <= kMaxScenes) return;
  // Keep scenes without sums: the result of their read would be dropped.
  std::erase_if(scenes_,
                [](const auto& entry) { return entry.second.sums && !entry.second.changed; });
}

void EventBus::LoadUnread() {
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

void EventBus::PublishSessions() {
  for (const auto& [id, change] : std::exchange(changed_sessions_, {})) {
    const bool has_ended = change.end != sessions::SessionEnd::kNone;
    const auto session = has_ended ? std::nullopt : sessions_.Describe(id);
    if (!has_ended && !session) continue;  // it has just left memory; the next tick reports its end
    const EventPtr event = MakeEvent(
        Kind::kSessions,
        Shared(has_ended ? encoder_.SessionEnd(id, change.end) : encoder_.Session(*session)));
    ForEachChannel(Kind::kSessions, change.scene, [&id = id, &event, has_ended](Channel& channel) {
      Put(channel, id, event);
      if (has_ended) channel.state.erase(id);
    });
  }
  for (const auto& [key, channel] : channels_) {
    if (channel->kind == Kind::kSessions) Wake(*channel);
  }
}

void EventBus::PublishRuns() {
  for (const SceneKey& scene : std::exchange(session_scenes_, {})) {
    ForEachChannel(Kind::kPosteriors, scene, [&](Channel& channel) {
      const auto known = channel.state.find(TextOf(scene));
      if (known == channel.state.end() || known->second->run == sessions_.RunOf(scene)) return;
      Put(channel, known->first, SceneEvent(scene, known->second->body));
      Wake(channel);
    });
  }
}

void EventBus::PublishDecisions(const SceneKey& scene, Decisions decisions) {
  if (decisions.count == 0) return;
  const EventPtr event = MakeEvent(Kind::kPosteriors, Shared(std::move(decisions.body)));
  ForEachChannel(Kind::kPosteriors, scene, [&](const Channel& channel) {
    for (Subscriber* subscriber : channel.subscribers) subscriber->PutDecisions(event);
    Wake(channel);
  });
}

void EventBus::PublishScene(const SceneEvidence& scene) {
  const EventPtr event = SceneEvent(scene.key, Shared(encoder_.Scene(scene)));
  ForEachChannel(Kind::kPosteriors, scene.key, [&](Channel& channel) {
    Put(channel, TextOf(scene.key), event);
    Wake(channel);
  });
}

void EventBus::Reset() {
  scenes_.clear();
  if (draining_) return;
  std::vector<ChannelPtr> channels;
  for (const auto& [key, channel] : channels_) {
    if (channel->kind == Kind::kPosteriors) channels.push_back(channel);
  }
  for (const ChannelPtr& channel : channels) {
    ++channel->load_count;
    channel->complete = false;
    for (Subscriber* subscriber : channel->subscribers) subscriber->Restart();
    channel->state.clear();
    LoadScenes(channel, {});
  }
}

void EventBus::Drain() {
  draining_ = true;
  scenes_.clear();
  changed_sessions_.clear();
  session_scenes_.clear();
  EndAll(Refused(sessions::reasons::kDraining, "the daemon is draining; watch again later"));
}

}  // namespace sweepstake::events
