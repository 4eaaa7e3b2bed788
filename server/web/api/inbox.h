// Runs tasks of other threads on the thread of the HTTP server. Thread-safe. It may outlive the
// server.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <mutex>
#include <utility>

namespace sweepstake::web {

class Inbox {
 public:
  explicit Inbox(boost::asio::io_context& io) : io_(&io) {}

  // Runs the task on the server's thread. After Close, drops it.
  template <typename Task>
  void Post(Task task) {
    const std::lock_guard lock(mutex_);
    if (io_ != nullptr) boost::asio::post(*io_, std::move(task));
  }
  // Must be called before `io` is destroyed.
  void Close() {
    const std::lock_guard lock(mutex_);
    io_ = nullptr;
  }

 private:
  std::mutex mutex_;
  boost::asio::io_context* io_;  // guarded by mutex_; null: closed
};

}  // namespace sweepstake::web
