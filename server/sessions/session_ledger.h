// Tracks which evidence of one session is on disk and which must still be written.
//
// Evidence is collected until the next checkpoint, which each tick makes. At that moment the
// evidence covers exactly the messages that have been applied. A checkpoint commits the evidence
// and the number of the last message in one atomic update. Acknowledged messages are therefore
// never lost, and resent messages are never counted twice. New evidence is kept apart until the
// next checkpoint, because a commit in between would write it without the number of its message.
//
// A session is not in the store until its client has sent a message. The first checkpoint with a
// message stores it, and the rows of its audit log wait until then. These rows are part of the
// update; if the disk is too slow for them (kMaxWaitingAuditBytes), further rows are lost.
//
// At most one update is pending. Later checkpoints merge into one further update, so the memory is
// bounded by the number of arms. A failed update is offered again, unchanged, at the next
// checkpoint. If it had reached the disk after all, the store recognizes its commit number and
// ignores it.
//
// If another daemon has written the session since this one read it from the store, the store
// refuses updates. Then superseded() is true, and everything that is not on disk is dropped,
// because the client resends it to the other daemon.
//
// It is used on the decision loop only. The store's callback posts to the loop and has only a weak
// pointer to the ledger.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/sessions/common/decision_loop.h"
#include "server/sessions/common/options.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::sessions {

class SessionLedger : public std::enable_shared_from_this<SessionLedger> {
 public:
  // Receives the status of a commit and the increments that have just reached the disk, if any.
  using CommitListener =
      std::function<void(const absl::Status&, std::span<const priors::KeyedEvidence>)>;

  // `progress` is the stored progress of the session; with commit_sequence 0, none is stored.
  // `on_committed` runs on the loop after each commit.
  SessionLedger(priors::AsyncPriorStore& store, DecisionLoop& loop, SessionCounters& counters,
                priors::SourceProgress progress, CommitListener on_committed);
  ~SessionLedger();
  SessionLedger(const SessionLedger&) = delete;
  SessionLedger& operator=(const SessionLedger&) = delete;

  void Add(const priors::KeyedEvidence& increment);
  // Sets the members of all updates that have these names; `known` is part of the first ones, until
  // one is stored. REQUIRES: no update was offered to the store yet.
  void SetOrigin(priors::SourceOrigin origin, bool is_of_player,
                 std::vector<priors::EvidenceKey> known) {
    origin_ = std::move(origin);
    is_of_player_ = is_of_player;
    known_ = std::move(known);
  }
  // Starts the session's audit log. `head` identifies its segment, and has no rows.
  void StartAudit(priors::AuditRows head) { audit_ = std::move(head); }
  // Adds the bytes of the next row. REQUIRES: StartAudit was called.
  void AddAuditRow(std::string row);
  // The progress of a session, as SourceProgress stores it.
  struct Position {
    uint64_t message_sequence = 0;
    uint32_t explored_arm_count = 0;
    uint64_t decision_count = 0;
    uint64_t frame_count = 0;
  };
  // Declares that the evidence so far comes from exactly the messages up to
  // position.message_sequence, and offers it to the store.
  void Checkpoint(const Position& position);
  // Offers a failed update to the store again.
  void Retry() { CommitNext(); }

  uint64_t durable_sequence() const { return durable_sequence_; }
  // Appends the updates that are not on disk.
  void AppendWaiting(std::vector<priors::SourceUpdate>& updates) const;
  // Returns whether there is evidence since the latest checkpoint.
  bool open() const { return !open_.empty(); }
  // Returns whether no update waits for the disk.
  bool settled() const { return !offered_ && !checkpointed_; }
  // Returns whether an update was passed to the store and its result has not arrived.
  bool committing() const { return in_flight_; }
  bool superseded() const { return superseded_; }

 private:
  bool HasRoomFor(size_t audit_bytes) const;
  void CommitNext();
  // Returns the update of the latest checkpoint. REQUIRES: `checkpointed_`.
  priors::SourceUpdate NextUpdate() const;
  void MakeOffer();
  void Offer();
  void DropOffer();
  void DropAll();
  void OnCommitted(const absl::Status& status);

  priors::AsyncPriorStore& store_;
  DecisionLoop& loop_;
  SessionCounters& counters_;
  const CommitListener on_committed_;

  priors::SourceProgress progress_;  // progress at the latest checkpoint
  priors::SourceOrigin origin_;
  bool is_of_player_ = false;
  std::vector<priors::EvidenceKey> known_;
  const priors::SourceWriter writer_;
  uint64_t durable_sequence_;
  std::map<priors::EvidenceKey, priors::Evidence> open_;  // evidence since the latest checkpoint
  std::map<priors::EvidenceKey, priors::Evidence>
      waiting_;  // evidence up to the latest checkpoint that is not in `offered_`
  std::vector<priors::StoredAuditRow> open_rows_;  // rows since the latest checkpoint
  priors::AuditRows audit_;       // rows up to the latest checkpoint that are not in `offered_`
  uint64_t audit_row_count_ = 0;  // rows of the segment, lost ones included
  size_t audit_bytes_ = 0;        // size of all rows held here
  bool checkpointed_ = false;     // whether `waiting_` may be offered
  std::unique_ptr<priors::SourceUpdate> offered_;  // update that the store has not confirmed yet
  bool in_flight_ = false;                         // whether the store is writing `offered_`
  bool superseded_ = false;
};

}  // namespace sweepstake::sessions
