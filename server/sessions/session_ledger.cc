#include "server/sessions/session_ledger.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <random>
#include <utility>

#include "server/sessions/common/options.h"
#include "server/sessions/common/unix_time.h"

namespace sweepstake::sessions {
namespace {

// Returns a number that no other ledger of any daemon has. Used on decision loops.
uint64_t NextWriter() {
  static std::atomic<uint64_t> next = [] {
    std::random_device random;
    return uint64_t{random()} << 32 | random();
  }();
  const uint64_t writer = next.fetch_add(1, std::memory_order_relaxed);
  return writer == 0 ? NextWriter() : writer;
}

uint64_t UnixTimeS() { return static_cast<uint64_t>(std::max<int64_t>(0, priors::UnixNowS())); }

}  // namespace

SessionLedger::SessionLedger(priors::AsyncPriorStore& store, DecisionLoop& loop,
                             SessionCounters& counters, priors::SourceProgress progress,
                             CommitListener on_committed)
    : store_(store),
      loop_(loop),
      counters_(counters),
      on_committed_(std::move(on_committed)),
      progress_(std::move(progress)),
      writer_{.id = NextWriter(), .resumed_sequence = progress_.commit_sequence},
      durable_sequence_(progress_.message_sequence) {}

SessionLedger::~SessionLedger() { counters_.waiting_audit_bytes -= audit_bytes_; }

void SessionLedger::Add(const priors::KeyedEvidence& increment) {
  open_[increment.key] += increment.evidence;
}

void SessionLedger::AddAuditRow(std::string row) {
  ++audit_row_count_;
  if (!HasRoomFor(row.size())) {
    ++counters_.lost_audit_row_count;
    return;
  }
  audit_bytes_ += row.size();
  counters_.waiting_audit_bytes += row.size();
  open_rows_.push_back({.number = audit_row_count_, .bytes = std::move(row)});
}

bool SessionLedger::HasRoomFor(size_t audit_bytes) const {
  return audit_bytes_ + audit_bytes <= kMaxWaitingAuditBytesOfSession &&
         counters_.waiting_audit_bytes + audit_bytes <= kMaxWaitingAuditBytes;
}

void SessionLedger::Checkpoint(const Position& position) {
  const bool offered_before = progress_.commit_sequence > 0;
  if (position.message_sequence > progress_.message_sequence || !open_.empty() ||
      (offered_before && !open_rows_.empty()))
    checkpointed_ = true;
  progress_.message_sequence = position.message_sequence;
  progress_.explored_arm_count = position.explored_arm_count;
  progress_.decision_count = position.decision_count;
  progress_.frame_count = position.frame_count;
  for (const auto& [key, evidence] : open_) waiting_[key] += evidence;
  open_.clear();
  std::move(open_rows_.begin(), open_rows_.end(), std::back_inserter(audit_.rows));
  open_rows_.clear();
  CommitNext();
}

void SessionLedger::CommitNext() {
  if (superseded_) DropAll();
  if (in_flight_) return;
  if (!offered_) {
    if (!checkpointed_) return;
    MakeOffer();
  }
  Offer();
}

priors::SourceUpdate SessionLedger::NextUpdate() const {
  priors::SourceUpdate update{.progress = progress_,
                              .unix_time_s = UnixTimeS(),
                              .increments = {},
                              .audit = audit_,
                              .origin = origin_,
                              .writer = writer_,
                              .known = known_,
                              .is_of_player = is_of_player_};
  ++update.progress.commit_sequence;
  for (const auto& [key, evidence] : waiting_) update.increments.push_back({key, evidence});
  return update;
}

void SessionLedger::AppendWaiting(std::vector<priors::SourceUpdate>& updates) const {
  if (offered_) updates.push_back(*offered_);
  if (checkpointed_) updates.push_back(NextUpdate());
}

void SessionLedger::MakeOffer() {
  offered_ = std::make_unique<priors::SourceUpdate>(NextUpdate());
  progress_.commit_sequence = offered_->progress.commit_sequence;
  audit_.rows.clear();
  waiting_.clear();
  checkpointed_ = false;
}

void SessionLedger::Offer() {
  in_flight_ = true;
  store_.Commit(*offered_, [weak = weak_from_this(), &loop = loop_](const absl::Status& status) {
    loop.PostLater([weak, status] {
      if (const auto self = weak.lock()) self->OnCommitted(status);
    });
  });
}

void SessionLedger::DropOffer() {
  for (const priors::StoredAuditRow& row : offered_->audit.rows) {
    audit_bytes_ -= row.bytes.size();
    counters_.waiting_audit_bytes -= row.bytes.size();
  }
  offered_.reset();
}

void SessionLedger::DropAll() {
  for (const auto* rows : {&audit_.rows, &open_rows_}) {
    counters_.lost_audit_row_count += rows->size();
    for (const priors::StoredAuditRow& row : *rows) {
      audit_bytes_ -= row.bytes.size();
      counters_.waiting_audit_bytes -= row.bytes.size();
    }
  }
  audit_.rows.clear();
  open_rows_.clear();
  open_.clear();
  waiting_.clear();
  checkpointed_ = false;
}

void SessionLedger::OnCommitted(const absl::Status& status) {
  in_flight_ = false;
  std::vector<priors::KeyedEvidence> stored;
  if (status.ok()) {
    ++counters_.stored_commit_count;
    durable_sequence_ = offered_->progress.message_sequence;
    known_.clear();
    stored = std::move(offered_->increments);
    DropOffer();
  } else {
    ++counters_.failed_commit_count;
    // Drop an update that can never be stored, because it must not block later ones.
    superseded_ = absl::IsFailedPrecondition(status);
    if (priors::IsRefusal(status)) {
      counters_.lost_audit_row_count += offered_->audit.rows.size();
      DropOffer();
    }
  }
  if (superseded_) DropAll();
  on_committed_(status, stored);
  if (!offered_) CommitNext();
}

}  // namespace sweepstake::sessions
