#include "server/sessions/common/decision_loop.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

namespace sweepstake::sessions {
namespace {

// Maximum number of PostLater tasks, and of due PostAt tasks, that run in one turn of the loop. A
// Post task waits at most for this number of each.
constexpr size_t kLaterTasksPerTurn = 8;

}  // namespace

int64_t SteadyLoopClock::NowNs() const {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void SteadyLoopClock::WaitUntil(int64_t deadline_ns) {
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

void SteadyLoopClock::Wake() {
  {
    const std::lock_guard lock(mutex_);
    wake_ = true;
  }
  woken_.notify_one();
}

DecisionLoop::DecisionLoop(LoopClock& clock, OnTimer on_timer, Runner runner)
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

template <typename Queue>
void DecisionLoop::Put(Queue& queue, Task task) {
  bool first = false;
  {
    const std::lock_guard lock(mutex_);
    first = queue.empty();
    queue.push_back(std::move(task));
  }
  if (first) clock_.Wake();
}

void DecisionLoop::Post(Task task) { Put(posted_, std::move(task)); }

void DecisionLoop::PostLater(Task task) { Put(later_, std::move(task)); }

void DecisionLoop::PostAt(int64_t due_ns, Task task) {
  {
    const std::lock_guard lock(mutex_);
    timers_.emplace(due_ns, std::move(task));
  }
  if (std::this_thread::get_id() != thread_.get_id()) clock_.Wake();
}

bool DecisionLoop::Collect(Turn& turn) {
  const int64_t now_ns = clock_.NowNs();
  const std::lock_guard lock(mutex_);
  turn.ready.swap(posted_);
  const auto later_end =
      later_.begin() + static_cast<ptrdiff_t>(std::min(later_.size(), kLaterTasksPerTurn));
  std::move(later_.begin(), later_end, std::back_inserter(turn.ready));
  later_.erase(later_.begin(), later_end);
  while (!timers_.empty() && timers_.begin()->first <= now_ns &&
         turn.due.size() < kLaterTasksPerTurn) {
    turn.due.insert(turn.due.end(), timers_.extract(timers_.begin()));
  }
  turn.next_due_ns = timers_.empty() ? LoopClock::kNever : timers_.begin()->first;
  return !turn.empty() || !closing_;
}

void DecisionLoop::RunTasks(Turn& turn) {
  for (Task& task : turn.ready) task();
  turn.ready.clear();
  for (auto& [due_ns, task] : turn.due) {
    if (on_timer_) on_timer_(std::chrono::nanoseconds(clock_.NowNs() - due_ns));
    task();
  }
  turn.due.clear();
}

void DecisionLoop::Run() {
  Turn turn;
  while (Collect(turn)) {
    if (turn.empty()) clock_.WaitUntil(turn.next_due_ns);
    RunTasks(turn);
  }
}

int64_t DecisionLoop::RunReady() {
  Turn turn;
  while (Collect(turn) && !turn.empty()) RunTasks(turn);
  return turn.next_due_ns;
}

}  // namespace sweepstake::sessions
