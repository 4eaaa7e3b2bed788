#include "engine_client/broad_phase/host/polling_thread.h"

#include <utility>

namespace sweepstake {

PollingThread::PollingThread(const char* name, ThreadPriority priority)
    : name_(name), priority_(priority) {}

PollingThread::~PollingThread() {
  RequestStop();
  Join();
}

void PollingThread::Start(std::chrono::microseconds pause, Step step) {
  if (is_in_child()) return;
  const std::lock_guard lock(state_->join_mutex);
  state_->thread = std::thread([this, pause, step = std::move(step)] { Run(pause, step); });
}

void PollingThread::Wake() {
  if (is_in_child()) return;
  {
    const std::lock_guard lock(state_->mutex);
    state_->woken = true;
  }
  state_->changed.notify_one();
}

void PollingThread::RequestStop() {
  if (is_in_child()) return;
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
    state_->woken = true;
  }
  state_->changed.notify_one();
}

void PollingThread::Join() {
  if (is_in_child()) return;
  const std::lock_guard lock(state_->join_mutex);
  if (state_->thread.joinable()) state_->thread.join();
}

void PollingThread::Run(std::chrono::microseconds pause, const Step& step) {
  NoteThreadStarted(name_, priority_);
  for (;;) {
    bool stopping = false;
    {
      std::unique_lock lock(state_->mutex);
      state_->changed.wait_for(lock, pause, [this] { return state_->woken; });
      state_->woken = false;
      stopping = state_->stopping;
    }
    const std::optional<std::chrono::microseconds> next = step(stopping);
    if (!next) return;
    pause = *next;
  }
}

}  // namespace sweepstake
