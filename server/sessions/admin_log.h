// Writes the actions of administrators into the audit log: who ended a session, gave an order,
// imported evidence, or created or revoked a token, and when.
//
// The rows belong to the session kAdminSession. Each run of the daemon is one segment. Rows go to
// disk with the store's next commit; rows that could not be written wait and are offered to the
// store again.
//
// Thread safety: any thread may call Record; only the decision loop may call the other functions.
// The object must live until the loop has run its last task.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "engine_client/decider/audit/audit_log.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/common/options.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_ledger.h"

namespace sweepstake::sessions {

class AdminLog {
 public:
  // Maximum number of rows that wait because the store cannot be read. Further rows are lost and
  // counted.
  static constexpr size_t kMaxWaiting = 1'000;

  AdminLog(const HostedSessionOptions& options, DecisionLoop& loop, priors::AsyncPriorStore& store,
           SessionCounters& counters)
      : options_(options), loop_(loop), store_(store), counters_(counters) {}

  // Adds a row. `who` is the subject of a sentence and `action` is the rest of it, without the full
  // stop.
  void Record(std::string who, std::string action);

  // Repeats a read or write of the store that has failed.
  void Retry();
  // Appends the updates that are not on disk.
  void AppendWaiting(std::vector<priors::SourceUpdate>& updates) const {
    if (ledger_ != nullptr) ledger_->AppendWaiting(updates);
  }
  // Returns whether a read or commit is under way.
  bool committing() const { return loading_ || (ledger_ != nullptr && ledger_->committing()); }

 private:
  struct Action {
    std::string who;
    std::string action;
    int64_t now_ns = 0;
    int64_t unix_ms = 0;
    uint64_t sequence = 0;  // sequence number of its row; 0 until it is added to the ledger
  };

  void Write();
  void Load();
  void OnLoaded(const absl::StatusOr<std::optional<priors::SourceState>>& state);
  // Begins a new segment with the unwritten rows, after another daemon has written to the
  // administrators' log.
  void StartAgain();

  const HostedSessionOptions& options_;
  DecisionLoop& loop_;
  priors::AsyncPriorStore& store_;
  SessionCounters& counters_;
  std::deque<Action> waiting_;  // actions that are not in the ledger yet
  std::deque<Action> offered_;  // actions in the ledger that are perhaps not in the store yet
  bool loading_ = false;
  std::shared_ptr<SessionLedger> ledger_;  // null until the store has been read
  std::optional<decision::AdminRows> rows_;
  uint64_t sequence_ = 0;  // sequence number of the latest row, over all segments
};

}  // namespace sweepstake::sessions
