#include "engine_client/telemetry/polling_thread.h"

#include <utility>

namespace sweepstake {

PollingThread::~PollingThread() {
  RequestStop();
  Join();
}

void PollingThread::Start(std::chrono::milliseconds interval, Step step) {
  const std::lock_guard lock(join_mutex_);
  thread_ = std::thread([this, interval, step = std::move(step)] { Run(interval, step); });
}

void PollingThread::Wake() {
  {
    const std::lock_guard lock(mutex_);
    woken_ = true;
  }
  changed_.notify_one();
}

void PollingThread::RequestStop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    woken_ = true;
  }
  changed_.notify_one();
}

void PollingThread::Join() {
  const std::lock_guard lock(join_mutex_);
  if (thread_.joinable()) thread_.join();
}

void PollingThread::Run(std::chrono::milliseconds interval, const Step& step) {
  for (;;) {
    bool stopping = false;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, interval, [this] { return woken_; });
      woken_ = false;
      stopping = stopping_;
    }
    if (!step(stopping)) return;
  }
}

}  // namespace sweepstake
