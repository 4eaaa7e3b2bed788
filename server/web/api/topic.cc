#include "server/web/api/topic.h"

#include <algorithm>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "server/web/error_page.h"

namespace sweepstake::web {
namespace {

constexpr char kSnapshotBegin[] = "event: snapshot-begin\ndata: {}\n\n";
constexpr char kComment[] = ":\n\n";

std::string DataOf(const std::string& json) { return absl::StrCat("data: ", json, "\n\n"); }

std::string SnapshotEnd(const std::string& id) {
  return absl::StrCat("id: ", id, "\nevent: snapshot-end\ndata: {}\n\n");
}

}  // namespace

// The answer to one who watches. Its connection owns it.
class Topic::Watcher final : public PartSource {
 public:
  Watcher(Topic& topic, WatcherShare share)
      : topic_(&topic), max_waiting_(topic.context_.limits.max_waiting), share_(std::move(share)) {}
  ~Watcher() override {
    if (topic_ != nullptr) topic_->Leave(*this);
  }

  // In place of what waits it gets the state, once it reads.
  void Skip() {
    waiting_.clear();
    skips_ = true;
    Wake();
  }
  void Push(const SharedText& text) {
    if (skips_) return;
    if (waiting_.size() == max_waiting_) {
      ++topic_->context_.counters.skip_count;
      return Skip();
    }
    waiting_.push_back(text);
    Wake();
  }
  void Beat(const SharedText& comment) {
    if (waiting_.empty()) Push(comment);
  }
  // The topic ends with this text.
  void End(const SharedText& text) {
    topic_ = nullptr;
    skips_ = false;
    waiting_.push_back(text);
    Wake();
  }

  void Start(std::function<void()> wake) override { wake_ = std::move(wake); }
  SharedText Next() override {
    if (skips_) {
      SharedText state = topic_->Snapshot();
      skips_ = false;
      return state;
    }
    if (waiting_.empty()) return nullptr;
    SharedText next = std::move(waiting_.front());
    waiting_.pop_front();
    return next;
  }
  bool ended() const override { return topic_ == nullptr && waiting_.empty(); }

 private:
  void Wake() const {
    if (wake_) wake_();
  }

  Topic* topic_;  // null once it has ended
  const size_t max_waiting_;
  const WatcherShare share_;
  std::function<void()> wake_;
  std::deque<SharedText> waiting_;
  bool skips_ = false;
};

Topic::Topic(TopicContext& context, std::unique_ptr<TopicState> state, std::function<void()> on_end)
    : context_(context),
      state_(std::move(state)),
      on_end_(std::move(on_end)),
      flush_timer_(context.io),
      idle_timer_(context.io) {
  ++context_.counters.open_topic_count;
}

Topic::~Topic() {
  --context_.counters.open_topic_count;
  context_.state_bytes -= state_bytes_;
}

void Topic::Open(UpstreamRequest request) {
  stream_ = context_.upstream.Open(
      std::move(request), [this](grpc::ByteBuffer bytes) { OnMessage(std::move(bytes)); },
      [this](const absl::Status& status) { OnEnd(status); });
}

void Topic::Join(std::shared_ptr<Exchange> exchange, WatcherShare share) {
  idle_timer_.cancel();
  if (begun_) return Begin(*exchange, std::move(share));
  waiting_.emplace_back(std::move(exchange), std::move(share));
}

void Topic::Begin(Exchange& exchange, WatcherShare share) {
  Flush();
  auto watcher = std::make_unique<Watcher>(*this, std::move(share));
  watchers_.insert(watcher.get());
  const SharedText missed = MissedSince(exchange.request().Header("Last-Event-ID"));
  missed ? watcher->Push(missed) : watcher->Skip();
  exchange.Stream("text/event-stream", std::move(watcher));
}

SharedText Topic::MissedSince(std::string_view id) const {
  const auto seen = std::find_if(kept_.begin(), kept_.end(),
                                 [id](const KeptMessage& message) { return message.id == id; });
  if (seen == kept_.end()) return nullptr;
  std::string missed = kComment;
  for (auto next = std::next(seen); next != kept_.end(); ++next) missed += next->text;
  return std::make_shared<const std::string>(std::move(missed));
}

SharedText Topic::Snapshot() {
  Flush();  // What is added is in the state already.
  if (snapshot_) return snapshot_;
  std::string text = kSnapshotBegin;
  text.reserve(state_->bytes() + state_->bytes() / 8);
  state_->Tell([&text](const std::string& json) { text += DataOf(json); });
  if (all_told_) text += SnapshotEnd(last_id_);
  snapshot_ = std::make_shared<const std::string>(std::move(text));
  return snapshot_;
}

void Topic::OnMessage(grpc::ByteBuffer bytes) {
  auto told = state_->Take(std::move(bytes));
  if (!told.ok()) return OnEnd(told.status());
  CountState();
  if (context_.state_bytes > context_.limits.max_state_bytes) {
    return OnEnd(absl::ResourceExhaustedError(
        "there is too much to show at once; watch one project or scene"));
  }
  snapshot_.reset();
  last_id_ = told->id;
  begun_ = true;
  for (auto& [exchange, share] : std::exchange(waiting_, {})) Begin(*exchange, std::move(share));
  if (told->all_told) {
    all_told_ = true;
    Keep(told->id, "");
    Add(SnapshotEnd(told->id));
    Flush();
  } else {
    ++context_.counters.encoded_count;
    // In the midst of the state an id would say that all before it was seen.
    const std::string id = all_told_ ? absl::StrCat("id: ", told->id, "\n") : "";
    const std::string text = id + DataOf(told->json);
    if (all_told_) Keep(told->id, text);
    Add(text);
  }
  stream_->Read();
}

void Topic::OnEnd(const absl::Status& status) {
  stream_.reset();
  const absl::Status why =
      status.ok() ? absl::UnavailableError("the daemon ended the stream; watch again") : status;
  for (auto& [exchange, share] : std::exchange(waiting_, {})) exchange->Answer(ErrorPage(why));
  Flush();
  const auto text = std::make_shared<const std::string>("event: error\n" + DataOf(ErrorJson(why)));
  for (Watcher* watcher : std::exchange(watchers_, {})) watcher->End(text);
  on_end_();
}

void Topic::CountState() {
  context_.state_bytes += state_->bytes() - state_bytes_;
  state_bytes_ = state_->bytes();
}

void Topic::Keep(const std::string& id, const std::string& text) {
  kept_.push_back({id, text});
  kept_bytes_ += text.size();
  while (kept_bytes_ > context_.limits.kept_bytes) {
    kept_bytes_ -= kept_.front().text.size();
    kept_.pop_front();
  }
}

void Topic::Add(const std::string& text) {
  const bool first = added_.empty();
  added_ += text;
  if (!first) return;
  flush_timer_.expires_after(context_.limits.moment);
  flush_timer_.async_wait([weak = weak_from_this()](boost::system::error_code cancelled) {
    if (const auto self = weak.lock(); self && !cancelled) self->Flush();
  });
}

void Topic::Flush() {
  if (added_.empty()) return;
  flush_timer_.cancel();
  const auto text = std::make_shared<const std::string>(std::exchange(added_, {}));
  for (Watcher* watcher : watchers_) watcher->Push(text);
}

void Topic::Beat() {
  static const auto comment = std::make_shared<const std::string>(kComment);
  for (Watcher* watcher : watchers_) watcher->Beat(comment);
}

void Topic::Leave(Watcher& watcher) {
  watchers_.erase(&watcher);
  if (!idle()) return;
  idle_timer_.expires_after(context_.limits.idle_patience);
  idle_timer_.async_wait([weak = weak_from_this()](boost::system::error_code cancelled) {
    // Somebody may have come since the time was up.
    if (const auto self = weak.lock(); self && !cancelled && self->idle()) self->on_end_();
  });
}

}  // namespace sweepstake::web
