#include "server/web/api/calls.h"

#include <boost/asio/steady_timer.hpp>
#include <chrono>

#include "server/web/error_page.h"

namespace sweepstake::web {
namespace {

constexpr char kLines[] = "application/x-ndjson";
// Time limit of a call with one response. An order waits up to five seconds for its game, and a
// read of the store waits for earlier reads.
constexpr std::chrono::seconds kAnswerPatience{30};

}  // namespace

struct Calls::Answer {
  const Method& method;
  std::shared_ptr<Exchange> exchange;  // null after the answer has begun
  boost::asio::steady_timer timer;
  Taken taken = {};
  std::function<void()> wake = {};
  std::string lines = {};  // lines that are not sent yet
  bool ended = false;
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
    return lines;
  }
  bool ended() const override { return answer_->ended && answer_->lines.empty(); }

 private:
  Calls& calls_;
  const uint64_t number_;
  const std::shared_ptr<Answer> answer_;
};

void Calls::Begin(const Method& method, std::shared_ptr<const google::protobuf::Message> request,
                  const std::optional<std::string>& token, std::shared_ptr<Exchange> exchange) {
  const uint64_t number = ++last_number_;
  const std::string peer = exchange->request().peer;
  const auto answer =
      std::make_shared<Answer>(Answer{.method = method,
                                      .exchange = std::move(exchange),
                                      .timer = boost::asio::steady_timer(io_, kAnswerPatience)});
  answers_[number] = answer;
  if (!method.streams) {
    answer->timer.async_wait([this, number](boost::system::error_code cancelled) {
      if (!cancelled)
        OnCallEnd(number, absl::DeadlineExceededError(
                              "the daemon did not answer in time; try again later"));
    });
  }
  // The callbacks own no objects of this thread, because another thread may destroy the callbacks.
  const bool begun = begin_(
      std::move(request), peer, token,
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
  auto json = ToJson(response);
  if (!json.ok()) return OnCallEnd(number, json.status());
  if (!answer.method.streams)
    return Finish(number, {.body = *std::move(json), .content_type = "application/json"});
  answer.lines = *json + "\n";
  answer.taken = std::move(taken);
  ShowLines(number);
}

void Calls::OnCallEnd(uint64_t number, const absl::Status& status) {
  const auto found = answers_.find(number);
  if (found == answers_.end()) return;
  Answer& answer = *found->second;
  if (!status.ok() && answer.exchange) return Finish(number, ErrorPage(status));
  answer.ended = true;
  if (!status.ok()) answer.lines += ErrorJson(status) + "\n";
  ShowLines(number);
}

void Calls::Finish(uint64_t number, Page page) {
  const auto answer = answers_.extract(number).mapped();
  answer->exchange->Answer(std::move(page));
}

void Calls::ShowLines(uint64_t number) {
  const std::shared_ptr<Answer> answer = answers_.at(number);
  if (!answer->exchange) return answer->wake();
  const auto exchange = std::exchange(answer->exchange, {});
  exchange->Stream(kLines, std::make_unique<Lines>(*this, number, answer));
}

}  // namespace sweepstake::web
