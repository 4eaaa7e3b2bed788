#include "server/storage/folding/evidence_folding.h"

#include <future>
#include <memory>
#include <utility>

namespace sweepstake::storage {

FoldWalk::FoldWalk(const FoldPlan& plan, uint64_t unix_now_s) : rows_per_step_(plan.rows_per_step) {
  const uint64_t age_s = uint64_t{plan.days} * 86'400;
  last_unix_s_ = unix_now_s > age_s ? unix_now_s - age_s : 0;
}

void FoldWalk::Step(priors::PriorStore& store) {
  const auto step = FoldSources(store, place_, last_unix_s_, rows_per_step_);
  if (!step.ok()) return Fail(step.status());
  run_.source_count += step->source_count;
  run_.record_count += step->record_count;
  place_ = step->next;
  done_ = step->last;
}

void FoldWalk::Fail(const absl::Status& status) {
  run_.status = status;
  done_ = true;
}

EvidenceFolding::EvidenceFolding(priors::AsyncPriorStore& store, const FoldPlan& plan,
                                 std::function<uint64_t()> unix_now_s, OnDone on_done)
    : store_(store),
      plan_(plan),
      unix_now_s_(std::move(unix_now_s)),
      on_done_(std::move(on_done)),
      thread_([this](const std::stop_token& stop) { Loop(stop); }) {}

bool EvidenceFolding::Sleep(const std::stop_token& stop, std::chrono::milliseconds duration) {
  std::unique_lock lock(mutex_);
  sleep_.wait_for(lock, stop, duration, [] { return false; });
  return !stop.stop_requested();
}

void EvidenceFolding::Loop(const std::stop_token& stop) {
  if (plan_.days == 0) return;
  while (true) {
    on_done_(RunOnce(stop));
    if (!Sleep(stop, plan_.interval)) return;
  }
}

FoldRun EvidenceFolding::RunOnce(const std::stop_token& stop) {
  FoldWalk walk(plan_, unix_now_s_());
  while (!walk.done() && Sleep(stop, plan_.pause)) RunStep(walk);
  return walk.run();
}

// A job that was taken always runs, also while the store closes.
void EvidenceFolding::RunStep(FoldWalk& walk) {
  auto stepped = std::make_shared<std::promise<void>>();
  std::future<void> done = stepped->get_future();
  const bool submitted = store_.Submit([stepped, &walk](priors::PriorStore& store) {
    walk.Step(store);
    stepped->set_value();
  });
  if (!submitted) return walk.Fail(absl::UnavailableError("the store has too much to do"));
  done.wait();
}

}  // namespace sweepstake::storage
