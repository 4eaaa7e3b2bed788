#include "server/history/history.h"

#include <boost/asio/post.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/sessions/audit_rows.h"
#include "server/sessions/common/unix_time.h"

namespace sweepstake::history {
namespace {

constexpr std::chrono::minutes kReportInterval{1};

}  // namespace

absl::StatusOr<std::unique_ptr<History>> History::Open(const std::filesystem::path& path,
                                                       const HistoryLimits& limits,
                                                       OnProblem on_problem) {
  std::string note;
  auto file = HistoryFile::Open(path, &note);
  if (!file.ok()) return file.status();
  if (!note.empty()) on_problem(note);
  return std::unique_ptr<History>(new History(*std::move(file), limits, std::move(on_problem)));
}

bool History::Post(std::function<void()> job) {
  if (closed_ || queued_count_ >= kMaxQueued) return false;
  ++queued_count_;
  boost::asio::post(thread_, [this, job = std::move(job)] {
    job();
    --queued_count_;
  });
  return true;
}

void History::Write(std::vector<HistoryEntry> entries) {
  Post([this, entries = std::move(entries)] {
    const absl::Status status =
        file_->Add(entries, limits_, priors::UnixNowS(), priors::SteadyNs());
    if (!status.ok())
      Report(absl::StrCat("the history could not be written, and lacks some points: ",
                          status.message()));
  });
}

bool History::Read(HistoryQuery query, OnPage done) {
  return Post([this, query = std::move(query), done = std::move(done)] {
    done(file_->Read(query, priors::UnixNowS()));
  });
}

void History::Limit(const HistoryLimits& limits) {
  Post([this, limits] { limits_ = limits; });
}

void History::Report(const std::string& problem) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_report_) return;
  next_report_ = now + kReportInterval;
  on_problem_(problem);
}

void History::Close() {
  if (!closed_.exchange(true)) thread_.join();
}

}  // namespace sweepstake::history
