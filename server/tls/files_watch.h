// Follows the files of a TLS endpoint that runs, and tells what becomes of them. gRPC reads the
// same files as often and says nothing: it goes on with those before while one cannot be read, and
// connections that begin fail while one is broken.
//
// Thread-safe. It owns one thread, which the destructor ends; what it tells, it tells there, at the
// first look on the thread of the constructor.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "engine_client/telemetry/tls/tls_files.h"

namespace sweepstake::tls {

struct FilesWatchOptions {
  std::chrono::milliseconds interval{1'000};
  bool own_thread = true;               // if false the owner calls Look
  std::function<int64_t()> unix_now_s;  // the wall clock
  // Told at the first look, and when the files have changed: with OK, or with why they cannot be
  // used, and when the certificate in use expires. A problem is told once, at the second look that
  // meets it, since a certificate and its key are replaced one after the other.
  std::function<void(const absl::Status&, int64_t expires_unix_s)> on_change;
  // Told when the certificate in use has expired, or will within a week; once, and again each day.
  std::function<void(int64_t expires_unix_s)> on_expiry;
};

class FilesWatch {
 public:
  FilesWatch(Files files, FilesWatchOptions options);
  ~FilesWatch() = default;
  FilesWatch(const FilesWatch&) = delete;
  FilesWatch& operator=(const FilesWatch&) = delete;

  // Reads the files. REQUIRES: there is no own thread.
  void Look();

 private:
  void Loop(const std::stop_token& stop);
  void OnProblem(const absl::Status& status);
  void OnRead(const Texts& texts);
  void TellExpiry();

  const Files files_;
  const FilesWatchOptions options_;
  // These are used by one thread at a time.
  std::optional<std::string> certificates_;  // that are in use: the endpoint's and authorities
  std::string met_;                          // the problem of the latest look; empty if none
  std::string told_;                         // the problem that was told last; empty if none
  int64_t expires_unix_s_ = 0;
  std::optional<int64_t> expiry_told_unix_s_;

  std::mutex mutex_;  // of the sleep alone
  std::condition_variable_any sleep_;
  std::jthread thread_;  // the last member, because it uses the others
};

}  // namespace sweepstake::tls
