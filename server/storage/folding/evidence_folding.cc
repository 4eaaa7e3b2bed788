#include "server/storage/folding/evidence_folding.h"

#include <future>
#include <memory>
#include <utility>

namespace sweepstake::storage {

EvidenceFolding::EvidenceFolding(priors::AsyncPriorStore& store, const FoldPlan& plan,
                                 std::function<uint64_t()> unix_now_s, OnDone on_done)
    : store_(store),
      plan_(plan),
      unix_now_s_(std::move(unix_now_s)),
      on_done_(std::move(on_done)),
      thread_([this] { Loop(); }) {}

EvidenceFolding::~EvidenceFolding() {
  Stop();
  thread_.join();
}

void EvidenceFolding::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
}

bool EvidenceFolding::Sleep(std::chrono::milliseconds duration) {
  std::unique_lock lock(mutex_);
  return !changed_.wait_for(lock, duration, [this] { return stopping_; });
}

void EvidenceFolding::Loop() {
  if (plan_.days == 0) return;
  while (true) {
    on_done_(RunOnce());
    if (!Sleep(plan_.interval)) return;
  }
}

FoldRun EvidenceFolding::RunOnce() {
  FoldRun run;
  const uint64_t now_s = unix_now_s_();
  const uint64_t age_s = uint64_t{plan_.days} * 86'400;
  const uint64_t last_unix_s = now_s > age_s ? now_s - age_s : 0;
  FoldPlace place;
  while (Sleep(plan_.pause)) {
    const auto step = RunStep(place, last_unix_s);
    run.status = step.status();
    if (!step.ok()) break;
    run.source_count += step->source_count;
    run.record_count += step->record_count;
    place = step->next;
    if (step->last) break;
  }
  return run;
}

// A job that was taken always runs, also while the store closes.
absl::StatusOr<FoldStep> EvidenceFolding::RunStep(const FoldPlace& after, uint64_t last_unix_s) {
  auto result = std::make_shared<std::promise<absl::StatusOr<FoldStep>>>();
  std::future<absl::StatusOr<FoldStep>> done = result->get_future();
  const bool submitted = store_.Submit([result, after, last_unix_s](priors::PriorStore& store) {
    result->set_value(FoldSources(store, after, last_unix_s));
  });
  if (!submitted) return absl::UnavailableError("the store has too much to do");
  return done.get();
}

}  // namespace sweepstake::storage
