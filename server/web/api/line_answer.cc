#include "server/web/api/line_answer.h"

#include <string>
#include <utility>

#include "server/web/error_page.h"

namespace sweepstake::web {
namespace {

constexpr char kLines[] = "application/x-ndjson";

// The call, and the lines that wait for the client. The callbacks of the call keep it alive. The
// call ends when the source is destroyed.
class LineAnswer : public std::enable_shared_from_this<LineAnswer> {
 public:
  LineAnswer(const Method& method, std::shared_ptr<Exchange> exchange)
      : method_(method), exchange_(std::move(exchange)) {}

  void Begin(Upstream& upstream, UpstreamRequest request) {
    const auto self = shared_from_this();
    stream_ = upstream.Open(
        std::move(request), [self](grpc::ByteBuffer bytes) { self->OnMessage(std::move(bytes)); },
        [self](const absl::Status& status) { self->OnEnd(status); });
  }

  void SetWake(std::function<void()> wake) { wake_ = std::move(wake); }
  std::shared_ptr<const std::string> Next() {
    if (lines_.empty()) return nullptr;
    auto lines = std::make_shared<const std::string>(std::exchange(lines_, {}));
    if (stream_) stream_->Read();
    return lines;
  }
  bool ended() const { return !stream_ && lines_.empty(); }
  void Cancel() { stream_.reset(); }

 private:
  class Source;

  void OnMessage(grpc::ByteBuffer bytes) {
    const auto json = ToJson(std::move(bytes), *method_.response);
    if (!json.ok()) return OnEnd(json.status());
    lines_ = *json + "\n";
    Show();
  }
  void OnEnd(const absl::Status& status) {
    stream_.reset();
    if (!status.ok() && exchange_) return std::exchange(exchange_, {})->Answer(ErrorPage(status));
    if (!status.ok()) lines_ += ErrorJson(status) + "\n";
    Show();
  }
  void Show();

  const Method& method_;
  std::shared_ptr<Exchange> exchange_;  // null once it is answered
  std::unique_ptr<Upstream::Stream> stream_;
  std::function<void()> wake_;
  std::string lines_;
};

class LineAnswer::Source final : public PartSource {
 public:
  explicit Source(std::shared_ptr<LineAnswer> answer) : answer_(std::move(answer)) {}
  ~Source() override { answer_->Cancel(); }
  void Start(std::function<void()> wake) override { answer_->SetWake(std::move(wake)); }
  std::shared_ptr<const std::string> Next() override { return answer_->Next(); }
  bool ended() const override { return answer_->ended(); }

 private:
  const std::shared_ptr<LineAnswer> answer_;
};

void LineAnswer::Show() {
  if (!exchange_) return wake_();
  const auto exchange = std::exchange(exchange_, {});
  exchange->Stream(kLines, std::make_unique<Source>(shared_from_this()));
}

}  // namespace

void AnswerWithLines(Upstream& upstream, const Method& method, UpstreamRequest request,
                     std::shared_ptr<Exchange> exchange) {
  std::make_shared<LineAnswer>(method, std::move(exchange))->Begin(upstream, std::move(request));
}

}  // namespace sweepstake::web
