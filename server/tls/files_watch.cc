#include "server/tls/files_watch.h"

#include <cstdlib>
#include <utility>

namespace sweepstake::tls {
namespace {

constexpr int64_t kDayS = 86'400;
constexpr int64_t kSoonS = 7 * kDayS;

}  // namespace

FilesWatch::FilesWatch(Files files, FilesWatchOptions options)
    : files_(std::move(files)), options_(std::move(options)) {
  Look();
  if (options_.own_thread)
    thread_ = std::jthread([this](const std::stop_token& stop) { Loop(stop); });
}

void FilesWatch::Loop(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (true) {
    sleep_.wait_for(lock, stop, options_.interval, [] { return false; });
    if (stop.stop_requested()) return;
    Look();
  }
}

void FilesWatch::Look() {
  if (const auto texts = Read(files_); texts.ok()) {
    OnRead(*texts);
  } else {
    OnProblem(texts.status());
  }
  TellExpiry();
}

void FilesWatch::OnProblem(const absl::Status& status) {
  const std::string problem(status.message());
  const bool lasts = std::exchange(met_, problem) == problem;
  if (!lasts || std::exchange(told_, problem) == problem) return;
  options_.on_change(status, expires_unix_s_);
}

void FilesWatch::OnRead(const Texts& texts) {
  met_.clear();
  std::string certificates = texts.cert + texts.ca;
  const bool mended = !std::exchange(told_, {}).empty();
  if (certificates_ == certificates && !mended) return;
  certificates_ = std::move(certificates);
  expires_unix_s_ = EarliestExpiryUnixS(texts.cert);
  expiry_told_unix_s_.reset();
  options_.on_change(absl::OkStatus(), expires_unix_s_);
}

void FilesWatch::TellExpiry() {
  const int64_t now_s = options_.unix_now_s();
  if (!certificates_ || expires_unix_s_ - now_s > kSoonS) return;
  // Uses the absolute value, because the wall clock may jump back.
  if (expiry_told_unix_s_ && std::abs(now_s - *expiry_told_unix_s_) < kDayS) return;
  expiry_told_unix_s_ = now_s;
  options_.on_expiry(expires_unix_s_);
}

}  // namespace sweepstake::tls
