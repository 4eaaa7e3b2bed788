#include "server/events/subscriber.h"

#include <utility>

#include "server/events/event_bus.h"

namespace sweepstake::events {

Subscriber::Subscriber(EventBus& bus, Wish wish, Sink& sink)
    : bus_(bus), wish_(std::move(wish)), sink_(sink) {}

Subscriber::~Subscriber() { bus_.Remove(*this); }

void Subscriber::Put(const std::string& key, const EventPtr& event) {
  // Queue the event only if the cursor has passed the key. Otherwise the next snapshot has it, or
  // NextOfState sends the new state when the cursor gets there.
  if (cursor_ && (wish_.snapshots || key > *cursor_)) return;
  if (latest_.insert_or_assign(key, event).second) queue_.push_back({key, nullptr});
}

void Subscriber::PutDecisions(const EventPtr& event) {
  const size_t bytes = event->body->size();
  if (decision_bytes_ + bytes > kQueueBytes) {
    std::erase_if(queue_, [](const Place& place) { return place.decisions != nullptr; });
    decision_bytes_ = 0;
  }
  queue_.push_back({{}, event});
  decision_bytes_ += bytes;
}

void Subscriber::Restart() {
  needs_snapshot_ = wish_.snapshots;
  if (!wish_.snapshots) {
    for (const auto& [key, event] : channel_->state) earlier_.insert(key);
  }
  cursor_ = "";
  std::erase_if(queue_, [](const Place& place) { return place.decisions == nullptr; });
  latest_.clear();
}

std::vector<EventPtr> Subscriber::Take(size_t max) {
  std::vector<EventPtr> taken;
  if (channel_ == nullptr) return taken;
  while (cursor_ && !wish_.snapshots && taken.size() < max) {
    EventPtr next = NextOfState();
    if (next == nullptr) break;
    taken.push_back(std::move(next));
  }
  if (!taken.empty()) return taken;
  if (cursor_) {
    if (!channel_->complete || wish_.snapshots) return taken;
    cursor_.reset();
  }
  while (taken.size() < max) {
    EventPtr next = NextOfEarlier();
    if (next == nullptr) next = NextOfQueue();
    if (next == nullptr) break;
    taken.push_back(std::move(next));
  }
  return taken;
}

EventPtr Subscriber::NextOfState() {
  for (;;) {
    const auto next = channel_->state.upper_bound(*cursor_);
    if (next == channel_->state.end()) return nullptr;
    cursor_ = next->first;
    if (EventPtr event = bus_.Refreshed(*channel_, next->first, next->second)) return event;
  }
}

EventPtr Subscriber::NextOfEarlier() {
  while (!earlier_.empty()) {
    const std::string key = std::move(earlier_.extract(earlier_.begin()).value());
    if (!channel_->state.contains(key)) return bus_.EmptyScene(key);
  }
  return nullptr;
}

EventPtr Subscriber::NextOfQueue() {
  if (queue_.empty()) return nullptr;
  Place next = std::move(queue_.front());
  queue_.pop_front();
  if (next.decisions == nullptr) return std::move(latest_.extract(next.key).mapped());
  decision_bytes_ -= next.decisions->body->size();
  return std::move(next.decisions);
}

std::optional<Subscriber::Snapshot> Subscriber::TakeSnapshot() {
  if (channel_ == nullptr || !channel_->complete) return std::nullopt;
  cursor_.reset();
  Snapshot snapshot{.stamp = bus_.NextStamp(),
                    .events = {},
                    .replaces_all = std::exchange(needs_snapshot_, false)};
  for (const auto& [key, event] : channel_->state) snapshot.events.push_back(event);
  return snapshot;
}

}  // namespace sweepstake::events
