#include "server/rpc/common/decision_loop.h"

#include <chrono>
#include <utility>

namespace sweepstake::rpc {

int64_t SteadyClock::NowNs() const {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void SteadyClock::WaitUntil(int64_t deadline_ns) {
  std::unique_lock lock(mutex_);
  const auto woken = [&] { return wake_; };
  if (deadline_ns == kNever) {
    woken_.wait(lock, woken);
  } else {
    const std::chrono::steady_clock::time_point deadline{std::chrono::nanoseconds(deadline_ns)};
    woken_.wait_until(lock, deadline, woken);
  }
  wake_ = false;
}

void SteadyClock::Wake() {
  {
    const std::lock_guard lock(mutex_);
    wake_ = true;
  }
  woken_.notify_one();
}

DecisionLoop::DecisionLoop(Clock& clock, OnTimer on_timer, Runner runner)
    : clock_(clock), on_timer_(std::move(on_timer)) {
  if (runner == Runner::kOwnThread) thread_ = std::thread([this] { Run(); });
}

DecisionLoop::~DecisionLoop() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  clock_.Wake();
  thread_.join();
}

void DecisionLoop::Post(Task task) {
  bool first = false;
  {
    const std::lock_guard lock(mutex_);
    first = posted_.empty();
    posted_.push_back(std::move(task));
  }
  if (first) clock_.Wake();
}

void DecisionLoop::PostAt(int64_t due_ns, Task task) {
  {
    const std::lock_guard lock(mutex_);
    timers_.emplace(due_ns, std::move(task));
  }
  if (std::this_thread::get_id() != thread_.get_id()) clock_.Wake();
}

bool DecisionLoop::Collect(std::vector<Task>& ready, Timers& due, int64_t& next_due_ns) {
  const int64_t now_ns = clock_.NowNs();
  const std::lock_guard lock(mutex_);
  ready.swap(posted_);
  while (!timers_.empty() && timers_.begin()->first <= now_ns) {
    due.insert(due.end(), timers_.extract(timers_.begin()));
  }
  next_due_ns = timers_.empty() ? Clock::kNever : timers_.begin()->first;
  return !ready.empty() || !due.empty() || !closing_;
}

void DecisionLoop::RunTasks(std::vector<Task>& ready, Timers& due) {
  for (Task& task : ready) task();
  ready.clear();
  for (auto& [due_ns, task] : due) {
    if (on_timer_) on_timer_(std::chrono::nanoseconds(clock_.NowNs() - due_ns));
    task();
  }
  due.clear();
}

void DecisionLoop::Run() {
  std::vector<Task> ready;
  Timers due;
  int64_t next_due_ns = Clock::kNever;
  while (Collect(ready, due, next_due_ns)) {
    if (ready.empty() && due.empty()) clock_.WaitUntil(next_due_ns);
    RunTasks(ready, due);
  }
}

int64_t DecisionLoop::RunReady() {
  std::vector<Task> ready;
  Timers due;
  int64_t next_due_ns = Clock::kNever;
  while (Collect(ready, due, next_due_ns) && !(ready.empty() && due.empty())) RunTasks(ready, due);
  return next_due_ns;
}

}  // namespace sweepstake::rpc
