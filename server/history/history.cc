#include "server/history/history.h"

#include <boost/asio/post.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/sessions/audit_rows.h"
#include "server/sessions/common/unix_time.h"

namespace sweepstake::history {
namespace {

constexpr std::chrono::minutes kReportInterval{1};

absl::Status NoFile() {
  return absl::UnavailableError("the history has no file, because it could not be opened again");
}

std::string BeginsAgain(const std::filesystem::path& path, const std::filesystem::path& aside,
                        const absl::Status& why) {
  return absl::StrCat("the history begins again, because ", path.string(), " is damaged (",
                      why.message(), "); it is now ", aside.string());
}

}  // namespace

absl::StatusOr<std::unique_ptr<History>> History::Open(const std::filesystem::path& path,
                                                       const HistoryLimits& limits,
                                                       OnProblem on_problem) {
  auto file = HistoryFile::Open(path);
  if (absl::IsDataLoss(file.status())) {
    const auto aside = HistoryFile::SetAside(path);
    if (!aside.ok()) return aside.status();
    on_problem(BeginsAgain(path, *aside, file.status()));
    file = HistoryFile::Open(path);
  }
  if (!file.ok()) return file.status();
  return std::unique_ptr<History>(
      new History(path, *std::move(file), limits, std::move(on_problem)));
}

History::History(std::filesystem::path path, std::unique_ptr<HistoryFile> file,
                 const HistoryLimits& limits, OnProblem on_problem)
    : path_(std::move(path)),
      on_problem_(std::move(on_problem)),
      file_(std::move(file)),
      limits_(limits) {
  Post([this] { Settle(file_->Check()); });
}

bool History::Post(std::function<void()> job, size_t report_count) {
  const std::lock_guard lock(mutex_);
  if (closed_ || queued_count_ >= kMaxQueued ||
      queued_report_count_ + report_count > kMaxQueuedReports)
    return false;
  ++queued_count_;
  queued_report_count_ += report_count;
  boost::asio::post(thread_, [this, report_count, job = std::move(job)] {
    job();
    const std::lock_guard done(mutex_);
    --queued_count_;
    queued_report_count_ -= report_count;
  });
  return true;
}

void History::Write(HistoryBatch batch) {
  const size_t report_count = batch.reports.size();
  const bool is_queued =
      Post([this, batch = std::move(batch)] { Settle(Add(batch)); }, report_count);
  if (!is_queued)
    Report("the history lacks some points, because the disk does not keep up with the games");
}

absl::Status History::Add(const HistoryBatch& batch) {
  if (file_ == nullptr) return NoFile();
  HistoryLimits limits;
  {
    const std::lock_guard lock(mutex_);
    limits = limits_;
  }
  return file_->Add(EntriesOf(batch), limits, priors::UnixNowS(), priors::SteadyNs());
}

void History::Settle(const absl::Status& status) {
  if (status.ok()) return;
  if (absl::IsNotFound(status)) return BeginAgain(std::string(status.message()));
  if (!absl::IsDataLoss(status))
    return Report(absl::StrCat("the history cannot be read or written: ", status.message()));
  file_.reset();
  const auto aside = HistoryFile::SetAside(path_);
  if (!aside.ok()) return Report(std::string(aside.status().message()));
  BeginAgain(BeginsAgain(path_, *aside, status));
}

void History::BeginAgain(const std::string& why) {
  file_.reset();
  auto file = HistoryFile::Open(path_);
  if (!file.ok()) return Report(std::string(file.status().message()));
  file_ = *std::move(file);
  Report(why);
}

bool History::Read(HistoryQuery query, OnPage done) {
  {
    const std::lock_guard lock(mutex_);
    if (queued_read_count_ >= kMaxQueuedReads) return false;
    ++queued_read_count_;
  }
  const bool is_queued = Post([this, query = std::move(query), done = std::move(done)] {
    if (closed_) {
      done(absl::CancelledError("the daemon is stopping"));
    } else {
      auto page = file_ == nullptr ? NoFile() : file_->Read(query, priors::UnixNowS());
      done(page);
      Settle(page.status());
    }
    EndRead();
  });
  if (!is_queued) EndRead();
  return is_queued;
}

void History::EndRead() {
  const std::lock_guard lock(mutex_);
  --queued_read_count_;
}

void History::Limit(const HistoryLimits& limits) {
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

void History::Report(const std::string& problem) {
  {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (now < next_report_) return;
    next_report_ = now + kReportInterval;
  }
  on_problem_(problem);
}

void History::Close() {
  {
    const std::lock_guard lock(mutex_);
    if (closed_.exchange(true)) return;
  }
  thread_.join();
}

}  // namespace sweepstake::history
