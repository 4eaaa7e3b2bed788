#include "server/rpc/session_table.h"

#include <utility>

namespace sweepstake::rpc {

std::shared_ptr<GameSession> SessionTable::Find(const std::string& id) const {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : found->second.session;
}

absl::Status SessionTable::Add(std::shared_ptr<GameSession> session) {
  if (entries_.size() >= options_.max_sessions && !MakeRoom()) {
    return absl::ResourceExhaustedError(
        "this daemon has as many sessions as it may; try again later, or use another");
  }
  std::string id = session->identity().id;
  entries_.emplace(std::move(id), Entry{.session = std::move(session)});
  return absl::OkStatus();
}

bool SessionTable::MakeRoom() {
  if (lost_.empty()) return false;
  Remove(std::string(lost_.begin()->second));
  return true;
}

void SessionTable::Attach(GameSession& session, SessionLink& link) {
  Entry& entry = entries_.at(session.identity().id);
  if (entry.link == nullptr) ++active_counts_[session.identity().scene];
  if (entry.lost_order != 0) lost_.erase(std::exchange(entry.lost_order, 0));
  entry.link = &link;
  session.Attach(link);
}

void SessionTable::Detach(GameSession& session, SessionLink& link) {
  const auto found = entries_.find(session.identity().id);
  if (found == entries_.end() || found->second.link != &link) return;
  found->second.link = nullptr;
  const auto count = active_counts_.find(session.identity().scene);
  if (--count->second == 0) active_counts_.erase(count);
  session.Detach(link);
  if (session.ended() && session.settled()) {
    Remove(std::string(found->first));
  } else {
    Lose(found->second);
  }
}

void SessionTable::Lose(Entry& entry) {
  const std::string& id = entry.session->identity().id;
  entry.lost_order = ++last_lost_order_;
  lost_.emplace(entry.lost_order, id);
  loop_.PostAt(loop_.clock().NowNs() + options_.resume_window_ns,
               [this, id, order = entry.lost_order] { OnResumeWindowOver(id, order); });
}

void SessionTable::OnResumeWindowOver(const std::string& id, uint64_t lost_order) {
  const auto found = entries_.find(id);
  if (found == entries_.end() || found->second.lost_order != lost_order) return;
  if (found->second.session->settled()) return Remove(id);
  // The disk was away: its evidence is only here.
  found->second.session->RetryCommit();
  lost_.erase(lost_order);
  Lose(found->second);
}

void SessionTable::Remove(const std::string& id) {
  const auto found = entries_.find(id);
  if (found->second.lost_order != 0) lost_.erase(found->second.lost_order);
  entries_.erase(found);
}

uint32_t SessionTable::ActiveCount(const priors::SceneKey& scene) const {
  const auto found = active_counts_.find(scene);
  return found == active_counts_.end() ? 0 : found->second;
}

}  // namespace sweepstake::rpc
