#include "server/web/api/calls.h"

#include <google/protobuf/descriptor.h>

#include <boost/asio/steady_timer.hpp>
#include <chrono>

#include "server/web/error_page.h"

namespace sweepstake::web {
namespace {

constexpr char kLines[] = "application/x-ndjson";
constexpr char kCsvType[] = "text/csv; charset=utf-8";
// Time limit of a call with one response. An order waits up to five seconds for its game, and a
// read of the store waits for earlier reads.
constexpr std::chrono::seconds kAnswerPatience{30};

// Returns the request of the page after `response`; null if it is the last page, or if the method
// has no pages.
std::unique_ptr<google::protobuf::Message> NextPage(const google::protobuf::Message& request,
                                                    const google::protobuf::Message& response) {
  const auto* next = response.GetDescriptor()->FindFieldByName("next_page_token");
  const auto* token = request.GetDescriptor()->FindFieldByName("page_token");
  if (next == nullptr || token == nullptr) return nullptr;
  std::string text = response.GetReflection()->GetString(response, next);
  if (text.empty()) return nullptr;
  std::unique_ptr<google::protobuf::Message> page(request.New());
  page->CopyFrom(request);
  page->GetReflection()->SetString(page.get(), token, std::move(text));
  return page;
}

}  // namespace

struct Calls::Answer {
  const Method& method;
  std::string peer;
  std::optional<std::string> token;
  std::shared_ptr<Exchange> exchange;  // null after the answer has begun
  boost::asio::steady_timer timer;
  std::unique_ptr<CsvTable> csv;  // null: the answer is JSON
  std::shared_ptr<const google::protobuf::Message> request;
  bool has_more = false;   // `request` is that of the next page, which was not called yet
  bool is_called = false;  // a call is running
  uint64_t call_count = 0;
  Taken taken = {};
  std::function<void()> wake = {};
  std::string lines = {};  // lines that are not sent yet
  bool ended = false;
  bool failed = false;
};

// Sends the lines of a stream. When this object is destroyed, the call ends.
class Calls::Lines final : public PartSource {
 public:
  Lines(Calls& calls, uint64_t number, std::shared_ptr<Answer> answer)
      : calls_(calls), number_(number), answer_(std::move(answer)) {}
  ~Lines() override { calls_.answers_.erase(number_); }
  void Start(std::function<void()> wake) override { answer_->wake = std::move(wake); }
  std::shared_ptr<const std::string> Next() override {
    if (answer_->lines.empty()) return nullptr;
    auto lines = std::make_shared<const std::string>(std::exchange(answer_->lines, {}));
    if (const Taken taken = std::move(answer_->taken)) *taken = true;
    if (answer_->has_more && !answer_->is_called) calls_.Call(number_);
    return lines;
  }
  bool ended() const override { return answer_->ended && answer_->lines.empty(); }
  bool failed() const override { return answer_->failed; }

 private:
  Calls& calls_;
  const uint64_t number_;
  const std::shared_ptr<Answer> answer_;
};

void Calls::Begin(const Method& method, std::unique_ptr<google::protobuf::Message> request,
                  const std::optional<std::string>& token, std::shared_ptr<Exchange> exchange,
                  std::unique_ptr<CsvTable> csv) {
  const uint64_t number = ++last_number_;
  const std::string peer = exchange->request().peer;
  answers_[number] = std::make_shared<Answer>(Answer{.method = method,
                                                     .peer = peer,
                                                     .token = token,
                                                     .exchange = std::move(exchange),
                                                     .timer = boost::asio::steady_timer(io_),
                                                     .csv = std::move(csv),
                                                     .request = std::move(request)});
  Call(number);
}

void Calls::Call(uint64_t number) {
  Answer& answer = *answers_.at(number);
  answer.is_called = true;
  answer.has_more = false;
  if (!answer.method.streams) {
    answer.timer.expires_after(kAnswerPatience);
    answer.timer.async_wait(
        [this, number, call = ++answer.call_count](boost::system::error_code cancelled) {
          // The timer of an earlier page may have run out just before it was cancelled.
          const auto waiting = answers_.find(number);
          if (waiting == answers_.end() || waiting->second->call_count != call) return;
          if (!cancelled)
            OnCallEnd(number, absl::DeadlineExceededError(
                                  "the daemon did not answer in time; try again later"));
        });
  }
  // The callbacks own no objects of this thread, because another thread may destroy the callbacks.
  const bool begun = begin_(
      answer.request, answer.peer, answer.token,
      [this, number, inbox = inbox_](const auto& response, Taken taken) {
        inbox->Post([this, number, response, taken = std::move(taken)]() mutable {
          OnCallResponse(number, *response, std::move(taken));
        });
      },
      [this, number, inbox = inbox_](const absl::Status& status) {
        inbox->Post([this, number, status] { OnCallEnd(number, status); });
      });
  if (!begun)
    OnCallEnd(number, absl::NotFoundError(
                          "this method sends events; request it under /events/ instead of /api/"));
}

void Calls::OnCallResponse(uint64_t number, const google::protobuf::Message& response,
                           Taken taken) {
  const auto found = answers_.find(number);
  if (found == answers_.end()) return;  // the client has disconnected
  Answer& answer = *found->second;
  answer.taken = std::move(taken);
  if (answer.csv) {
    answer.lines += answer.csv->Lines(response);
    if (auto next = NextPage(*answer.request, response)) {
      answer.request = std::move(next);
      answer.has_more = true;
    }
    // A response without rows counts as taken.
    if (answer.lines.empty() && answer.taken) *std::exchange(answer.taken, nullptr) = true;
  } else {
    auto json = ToJson(response);
    if (!json.ok()) return OnCallEnd(number, json.status());
    if (!answer.method.streams)
      return Finish(number, {.body = *std::move(json), .content_type = "application/json"});
    answer.lines = *json + "\n";
  }
  ShowLines(number);
}

void Calls::OnCallEnd(uint64_t number, const absl::Status& status) {
  const auto found = answers_.find(number);
  if (found == answers_.end()) return;
  Answer& answer = *found->second;
  answer.is_called = false;
  answer.timer.cancel();
  if (!status.ok() && answer.exchange) return Finish(number, ErrorPage(status));
  answer.failed = !status.ok() && answer.csv;
  answer.ended = !status.ok() || !answer.has_more;
  if (!status.ok() && !answer.csv) answer.lines += ErrorJson(status) + "\n";
  if (!answer.ended && answer.lines.empty()) return Call(number);
  ShowLines(number);
}

void Calls::Finish(uint64_t number, Page page) {
  const auto answer = answers_.extract(number).mapped();
  answer->exchange->Answer(std::move(page));
}

void Calls::ShowLines(uint64_t number) {
  const std::shared_ptr<Answer> answer = answers_.at(number);
  if (!answer->exchange) return answer->wake();
  StreamHead head{.content_type = kLines};
  if (answer->csv) {
    head.content_type = kCsvType;
    head.headers = {{"Content-Disposition", "attachment"}};
    answer->lines.insert(0, answer->csv->Header());
  }
  const auto exchange = std::exchange(answer->exchange, {});
  exchange->Stream(std::move(head), std::make_unique<Lines>(*this, number, answer));
}

}  // namespace sweepstake::web
