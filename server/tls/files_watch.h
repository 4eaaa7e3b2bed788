// Checks the files of a running TLS endpoint, and reports changes and problems. The listeners read
// the same files at the same interval (certificate.h), but report nothing. While the files cannot
// be used, they keep the previous certificate.
//
// Thread-safe. It owns one thread, which the destructor ends. Callbacks run on that thread, except
// for the first check, which runs in the constructor.
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
  bool own_thread = true;               // if false, the owner calls Look
  std::function<int64_t()> unix_now_s;  // the wall clock
  // Called at the first check and when the files have changed. The status is OK, or the reason why
  // the files cannot be used; `expires_unix_s` is the expiry of the certificate in use. A problem
  // is reported once, at the second check in a row that finds it. A single check may happen between
  // the replacement of a certificate and the replacement of its key.
  std::function<void(const absl::Status&, int64_t expires_unix_s)> on_change;
  // Called when the certificate in use has expired or expires within a week; repeated daily.
  std::function<void(int64_t expires_unix_s)> on_expiry;
};

class FilesWatch {
 public:
  FilesWatch(Files files, FilesWatchOptions options);
  ~FilesWatch() = default;
  FilesWatch(const FilesWatch&) = delete;
  FilesWatch& operator=(const FilesWatch&) = delete;

  // Reads the files. REQUIRES: own_thread is false.
  void Look();

 private:
  void Loop(const std::stop_token& stop);
  void OnProblem(const absl::Status& status);
  void OnRead(const Texts& texts);
  void TellExpiry();

  const Files files_;
  const FilesWatchOptions options_;
  // The members up to expiry_told_unix_s_ are used by one thread at a time. certificates_ is the
  // text of the certificate file and the authority file, as read last.
  std::optional<std::string> certificates_;
  std::string met_;   // problem found by the latest check; empty if none
  std::string told_;  // problem reported last; empty if none
  int64_t expires_unix_s_ = 0;
  std::optional<int64_t> expiry_told_unix_s_;

  std::mutex mutex_;  // used only to sleep
  std::condition_variable_any sleep_;
  std::jthread thread_;  // the last member, because it uses the others
};

}  // namespace sweepstake::tls
