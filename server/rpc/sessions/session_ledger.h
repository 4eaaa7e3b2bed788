// Knows which evidence of one session is on disk, and which is on its way there.
//
// Evidence waits for a checkpoint: a moment at which every message applied so far has been folded
// into it (a tick). A checkpoint commits the evidence together with the sequence number it covers,
// in one atomic update. So what a client is told to forget is never lost, and what it sends again
// is never counted twice. The rows of the session's audit log go with it; where the disk does not
// keep up with them (kMaxWaitingAuditBytes), the log ends. One update is in flight at a time; later
// checkpoints merge into one behind it, so memory is bounded by the number of arms. An update that
// failed is offered again, unchanged, at the next checkpoint. If it did reach the disk, the store
// ignores it by its number.
//
// It lives on the decision loop only. The store's callback posts to the loop and holds only a weak
// pointer to the ledger.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "server/priors/prior_store.h"
#include "server/rpc/common/decision_loop.h"
#include "server/rpc/common/options.h"

namespace sweepstake::rpc {

class SessionLedger : public std::enable_shared_from_this<SessionLedger> {
 public:
  // `progress` is what the store has (commit_sequence 0: nothing). `on_committed` runs on the loop
  // after each commit, with its outcome.
  SessionLedger(priors::AsyncPriorStore& store, DecisionLoop& loop, Counters& counters,
                priors::SourceProgress progress,
                std::function<void(const absl::Status&)> on_committed);

  void Add(const priors::KeyedEvidence& increment);
  // `head` says where the session's audit rows belong; it has no rows.
  void StartAudit(priors::AuditRows head) { audit_ = std::move(head); }
  // Adds the next row. REQUIRES: StartAudit was called.
  void AddAuditRow(std::string_view row);
  // How far a session has come, as far as SourceProgress keeps it.
  struct Position {
    uint64_t message_sequence = 0;
    uint32_t explored_arm_count = 0;
    uint64_t decision_count = 0;
    uint64_t frame_count = 0;
  };
  // Declares that the evidence so far is exactly that of the messages up to the position's.
  void Checkpoint(const Position& position);
  // Offers a failed update again.
  void Retry() { CommitNext(); }

  uint64_t durable_sequence() const { return durable_sequence_; }
  // Whether nothing waits for the disk.
  bool settled() const { return !offered_ && !checkpointed_; }
  // Whether the store has an update and has not answered yet.
  bool committing() const { return in_flight_; }

 private:
  void CommitNext();
  void Offer();
  void OnCommitted(const absl::Status& status);

  priors::AsyncPriorStore& store_;
  DecisionLoop& loop_;
  Counters& counters_;
  const std::function<void(const absl::Status&)> on_committed_;

  priors::SourceProgress progress_;  // of the latest checkpoint
  uint64_t durable_sequence_;
  std::map<priors::EvidenceKey, priors::Evidence> waiting_;  // since the latest offer
  priors::AuditRows audit_;                                  // since the latest offer
  size_t audit_bytes_ = 0;                                   // of its rows
  bool audit_cut_ = false;                                   // no more rows
  bool checkpointed_ = false;                                // `waiting_` may be offered
  std::optional<priors::SourceUpdate> offered_;              // not known to be durable
  bool in_flight_ = false;                                   // `offered_` is with the store
};

}  // namespace sweepstake::rpc
