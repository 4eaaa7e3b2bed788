#include "server/alerts/webhook.h"

#include <curl/curl.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sweepstake::alerts {
namespace {

constexpr size_t kMaxAnswerBytes = 64 * 1024;

// Ends the transfer after kMaxAnswerBytes: the status has arrived before the body.
size_t Discard(char* /*bytes*/, size_t size, size_t count, void* received) {
  auto& byte_count = *static_cast<size_t*>(received);
  byte_count += size * count;
  return byte_count > kMaxAnswerBytes ? 0 : size * count;
}

// libcurl calls it at least once a second; a value other than 0 ends the transfer.
int IsClosing(void* closing, curl_off_t /*total*/, curl_off_t /*received*/, curl_off_t /*to_send*/,
              curl_off_t /*sent*/) {
  return static_cast<const std::atomic<bool>*>(closing)->load() ? 1 : 0;
}

void InitialiseCurl() {
  static const CURLcode initialised = curl_global_init(CURL_GLOBAL_DEFAULT);
  (void)initialised;  // without it, curl_easy_init returns null
}

}  // namespace

Webhook::Webhook(Options options, sessions::LoopClock& clock)
    : options_(std::move(options)), clock_(clock), thread_([this] { Run(); }) {}

Webhook::~Webhook() {
  closing_ = true;
  clock_.Wake();
  thread_.join();
}

void Webhook::SetUrl(const std::string& url) {
  {
    const std::lock_guard lock(mutex_);
    if (url == url_) return;
    url_ = url;
    due_ns_ = 0;
    while (url_.empty() && !messages_.empty()) {
      Remove();
      ++counters_.dropped_count;
    }
  }
  clock_.Wake();
}

void Webhook::Post(std::string message) {
  {
    const std::lock_guard lock(mutex_);
    if (url_.empty()) return;
    if (messages_.size() >= kMaxQueued) {
      Remove();
      ++counters_.dropped_count;
    }
    messages_.push_back({.number = ++last_number_, .text = std::move(message)});
    counters_.queued_count = messages_.size();
  }
  clock_.Wake();
}

void Webhook::Remove() {
  messages_.pop_front();
  counters_.queued_count = messages_.size();
}

void Webhook::Run() {
  while (!closing_) clock_.WaitUntil(Step());
}

int64_t Webhook::Step() {
  std::string url;
  Message message;
  {
    const std::lock_guard lock(mutex_);
    if (messages_.empty()) return sessions::LoopClock::kNever;
    if (clock_.NowNs() < due_ns_) return due_ns_;
    message = messages_.front();
    url = url_;
  }
  const std::string problem = Send(url, message.text);
  if (closing_) return 0;
  Settle(message.number, url, problem);
  if (!problem.empty() && options_.on_problem && clock_.NowNs() >= next_report_ns_) {
    next_report_ns_ = clock_.NowNs() + kReportIntervalNs;
    options_.on_problem(problem);
  }
  return 0;
}

void Webhook::Settle(uint64_t number, const std::string& url, const std::string& problem) {
  const std::lock_guard lock(mutex_);
  ++(problem.empty() ? counters_.delivered_count : counters_.failed_count);
  // A full queue may have dropped the message meanwhile.
  if (messages_.empty() || messages_.front().number != number) return;
  Message& message = messages_.front();
  if (problem.empty()) {
    due_ns_ = 0;
    return Remove();
  }
  if (url != url_) return;  // a new receiver is tried at once
  const int64_t wait_ns = kFirstWaitNs << std::min(message.attempt_count, 6u);
  due_ns_ = clock_.NowNs() + std::min(wait_ns, kMaxWaitNs);
  if (++message.attempt_count < kMaxAttempts) return;
  Remove();
  ++counters_.dropped_count;
}

std::string Webhook::Send(const std::string& url, const std::string& message) {
  InitialiseCurl();
  const std::unique_ptr<CURL, void (*)(CURL*)> curl(curl_easy_init(), curl_easy_cleanup);
  const std::unique_ptr<curl_slist, void (*)(curl_slist*)> headers(
      curl_slist_append(nullptr, "Content-Type: application/json"), curl_slist_free_all);
  if (curl == nullptr || headers == nullptr) return "libcurl could not be initialised";
  const auto set = [&](CURLoption option, auto value) {
    (void)curl_easy_setopt(curl.get(), option, value);
  };
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_SSL_VERIFYPEER, 1L);
  set(CURLOPT_SSL_VERIFYHOST, 2L);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_TIMEOUT_MS, static_cast<long>(kAttemptTimeoutMs));
  set(CURLOPT_HTTPHEADER, headers.get());
  set(CURLOPT_USERAGENT, options_.user_agent.c_str());
  set(CURLOPT_POSTFIELDS, message.c_str());
  set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(message.size()));
  size_t received = 0;
  set(CURLOPT_WRITEFUNCTION, &Discard);
  set(CURLOPT_WRITEDATA, static_cast<void*>(&received));
  set(CURLOPT_XFERINFOFUNCTION, &IsClosing);
  set(CURLOPT_XFERINFODATA, static_cast<void*>(&closing_));
  set(CURLOPT_NOPROGRESS, 0L);
  const CURLcode sent = curl_easy_perform(curl.get());
  if (sent != CURLE_OK && sent != CURLE_WRITE_ERROR) return curl_easy_strerror(sent);
  long status = 0;
  (void)curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &status);
  if (status >= 200 && status < 300) return {};
  return absl::StrCat("the receiver answered with the status ", status);
}

}  // namespace sweepstake::alerts
