// The sessions in memory: connected ones, and lost ones that may come back. On the decision loop
// only.
//
// Bounded by RpcOptions::max_sessions and resume_window_ns; the store knows every session that has
// left.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>

#include "absl/status/status.h"
#include "server/rpc/game_session.h"

namespace sweepstake::rpc {

class SessionTable {
 public:
  explicit SessionTable(const RpcOptions& options, DecisionLoop& loop)
      : options_(options), loop_(loop) {}

  // Null: not in memory.
  std::shared_ptr<GameSession> Find(const std::string& id) const;
  // RESOURCE_EXHAUSTED: full of connected sessions. REQUIRES: its id is not in the table.
  absl::Status Add(std::shared_ptr<GameSession> session);

  void Attach(GameSession& session, SessionLink& link);
  // Nothing when the link is not the session's any more. An ended session leaves the table.
  void Detach(GameSession& session, SessionLink& link);

  uint32_t ActiveCount(const priors::SceneKey& scene) const;
  size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    std::shared_ptr<GameSession> session;
    SessionLink* link = nullptr;
    uint64_t lost_order = 0;  // 0: connected or never connected
  };

  bool MakeRoom();
  void Lose(Entry& entry);
  void OnResumeWindowOver(const std::string& id, uint64_t lost_order);
  void Remove(const std::string& id);

  const RpcOptions& options_;
  DecisionLoop& loop_;
  std::unordered_map<std::string, Entry> entries_;
  std::map<uint64_t, std::string> lost_;  // by the order of losing them
  std::map<priors::SceneKey, uint32_t> active_counts_;
  uint64_t last_lost_order_ = 0;
};

}  // namespace sweepstake::rpc
