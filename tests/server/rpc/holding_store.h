// A store that holds commits until the test releases or fails them. It can be closed while the
// store behind it continues.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include "server/sessions/prior_store.h"

namespace sweepstake::rpc {

class HoldingStore final : public priors::AsyncPriorStore {
 public:
  explicit HoldingStore(priors::AsyncPriorStore& store) : store_(store) {}

  void Commit(priors::SourceUpdate update, CommitCallback done) override {
    const std::lock_guard lock(mutex_);
    if (closed_) return done(absl::UnavailableError("the store is closed"));
    if (failing_) return done(absl::UnavailableError("the disk is full"));
    if (holding_) return held_.push_back({std::move(update), std::move(done)});
    store_.Commit(std::move(update), std::move(done));
  }
  bool Submit(Job job) override {
    const std::lock_guard lock(mutex_);
    const bool submitted = !closed_ && store_.Submit(std::move(job));
    ++submit_count_;
    return submitted;
  }
  bool Read(ReadJob job) override {
    const std::lock_guard lock(mutex_);
    const bool submitted = !closed_ && store_.Read(std::move(job));
    ++submit_count_;
    return submitted;
  }
  bool healthy() const override {
    const std::lock_guard lock(mutex_);
    return !failing_ && store_.healthy();
  }

  priors::StoreLosses losses() const override {
    return {.audit_row_count = lost_audit_row_count_,
            .player_increment_count = limited_increment_count_,
            .example = "scene s"};
  }

  void Hold() {
    const std::lock_guard lock(mutex_);
    holding_ = true;
  }
  void LoseAuditRows(uint64_t count) { lost_audit_row_count_ += count; }
  void LimitPlayers(uint64_t count) { limited_increment_count_ += count; }
  void Fail(bool failing) {
    const std::lock_guard lock(mutex_);
    failing_ = failing;
  }
  // Closes or reopens the store. A closed store refuses new calls; earlier calls still run.
  void Close(bool closed) {
    const std::lock_guard lock(mutex_);
    closed_ = closed;
  }
  // Number of jobs and reads offered so far.
  size_t submit_count() const { return submit_count_; }
  size_t held_count() const {
    const std::lock_guard lock(mutex_);
    return held_.size();
  }
  void Release() {
    std::vector<Held> held;
    {
      const std::lock_guard lock(mutex_);
      holding_ = false;
      held.swap(held_);
    }
    for (Held& commit : held) store_.Commit(std::move(commit.update), std::move(commit.done));
  }

 private:
  struct Held {
    priors::SourceUpdate update;
    CommitCallback done;
  };
  priors::AsyncPriorStore& store_;
  std::atomic<size_t> submit_count_{0};
  std::atomic<uint64_t> lost_audit_row_count_{0};
  std::atomic<uint64_t> limited_increment_count_{0};
  mutable std::mutex mutex_;
  std::vector<Held> held_;  // guarded by mutex_
  bool holding_ = false;    // guarded by mutex_
  bool failing_ = false;    // guarded by mutex_
  bool closed_ = false;     // guarded by mutex_
};

}  // namespace sweepstake::rpc
