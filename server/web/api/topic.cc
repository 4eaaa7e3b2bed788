#include "server/web/api/topic.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "server/web/error_page.h"

namespace sweepstake::web {
namespace {

constexpr char kSnapshotBegin[] = "event: snapshot-begin\ndata: {}\n\n";
constexpr char kComment[] = ":\n\n";
// Number of a snapshot's events that are converted to text at a time, which takes about 10 ms.
// Other requests are answered in between.
constexpr size_t kEventsAtOnce = 100;

std::string DataOf(const std::string& json) { return absl::StrCat("data: ", json, "\n\n"); }

std::string IdOf(const events::EventStamp& stamp) {
  return absl::StrCat(absl::Hex(stamp.boot, absl::kZeroPad16), ":", stamp.sequence);
}

SharedText Shared(std::string text) { return std::make_shared<const std::string>(std::move(text)); }

}  // namespace

// Passes events from the event bus to the topic. The subscription is used on the decision loop's
// thread, the topic on the server's thread. Only one batch is passed at a time. Until the server
// has processed it, further events wait in the subscriber, which limits their number.
class Topic::Feed final : public events::Sink, public std::enable_shared_from_this<Feed> {
 public:
  explicit Feed(Topic& topic)
      : topic_(&topic), inbox_(topic.context_.inbox), post_to_loop_(topic.context_.post_to_loop) {}

  // WantSnapshot and Close are called on the server's thread. After Close, topic_ is not used.
  void WantSnapshot() {
    post_to_loop_([self = shared_from_this()] {
      self->snapshot_wanted_ = true;
      self->Wake();
    });
  }
  void Close() {
    topic_ = nullptr;
    post_to_loop_([self = shared_from_this()] { self->subscriber_.reset(); });
  }

  // The functions below are called on the decision loop's thread.
  void Begin(std::unique_ptr<events::Subscriber> subscriber) override {
    subscriber_ = std::move(subscriber);
  }
  void Wake() override {
    if (under_way_ || subscriber_ == nullptr) return;
    Batch batch;
    for (auto events = subscriber_->Take(1); !events.empty(); events = subscriber_->Take(1))
      batch.events.push_back(std::move(events.front()));
    if (snapshot_wanted_ || subscriber_->needs_snapshot())
      batch.snapshot = subscriber_->TakeSnapshot();
    if (batch.snapshot) snapshot_wanted_ = false;
    if (batch.events.empty() && !batch.snapshot) return;
    under_way_ = true;
    Post([this, batch = std::move(batch)] {
      topic_->OnBatch(batch);
      post_to_loop_([self = shared_from_this()] {
        self->under_way_ = false;
        self->Wake();
      });
    });
  }
  void OnEnd(const absl::Status& status) override {
    Post([this, status] { topic_->OnEnd(status); });
    subscriber_.reset();
  }

 private:
  // Runs `call` on the server's thread, unless the feed has been closed before it runs.
  void Post(std::function<void()> call) {
    inbox_->Post([self = shared_from_this(), call = std::move(call)] {
      if (self->topic_ != nullptr) call();
    });
  }

  Topic* topic_;  // used on the server's thread; null: closed
  const std::shared_ptr<Inbox> inbox_;
  const PostToLoop post_to_loop_;
  // The members below are used on the decision loop's thread.
  std::unique_ptr<events::Subscriber> subscriber_;
  bool snapshot_wanted_ = false;
  bool under_way_ = false;  // the server has not processed the last batch yet
};

// A client that watches the topic, and the source of its answer. The client's connection owns it.
class Topic::Watcher final : public PartSource {
 public:
  Watcher(Topic& topic, WatcherShare share)
      : topic_(&topic), max_waiting_(topic.context_.limits.max_waiting), share_(std::move(share)) {}
  ~Watcher() override {
    if (topic_ != nullptr) topic_->Leave(*this);
  }

  void Push(const SharedText& text) {
    if (skips_) return;
    if (waiting_.size() < max_waiting_) {
      waiting_.push_back(text);
    } else {
      // When the client reads again, it receives a snapshot instead of the texts.
      Skip();
    }
    Wake();
  }
  void Beat(const SharedText& comment) {
    if (waiting_.empty()) Push(comment);
  }
  // Returns whether the watcher waits for a snapshot, which replaces the texts that it drops.
  bool wants_snapshot() const { return wants_snapshot_; }
  // Drops texts until the next snapshot, because that snapshot replaces the whole state.
  void AwaitSnapshot() {
    if (waiting_.size() >= max_waiting_) Skip();
    skips_ = wants_snapshot_ = true;
  }
  void PushSnapshot(const std::vector<SharedText>& texts) {
    skips_ = wants_snapshot_ = false;
    waiting_.insert(waiting_.end(), texts.begin(), texts.end());
    Wake();
  }
  // Sends the last text. The watcher does not use the topic afterwards.
  void End(const SharedText& text) {
    topic_ = nullptr;
    skips_ = false;
    waiting_.push_back(text);
    Wake();
  }

  void Start(std::function<void()> wake) override { wake_ = std::move(wake); }
  SharedText Next() override {
    if (skips_ && !wants_snapshot_) {
      wants_snapshot_ = true;
      topic_->WantSnapshot();
    }
    if (waiting_.empty()) return nullptr;
    SharedText next = std::move(waiting_.front());
    waiting_.pop_front();
    return next;
  }
  bool ended() const override { return topic_ == nullptr && waiting_.empty(); }
  bool endless() const override { return true; }

 private:
  // Drops the waiting texts, because the client reads too slowly.
  void Skip() {
    ++topic_->context_.counters.skip_count;
    waiting_.clear();
    skips_ = true;
  }
  void Wake() const {
    if (wake_) wake_();
  }

  Topic* topic_;  // null after End
  const size_t max_waiting_;
  const WatcherShare share_;
  std::function<void()> wake_;
  std::deque<SharedText> waiting_;
  bool skips_ = false;  // drops texts until the next PushSnapshot
  bool wants_snapshot_ = false;
};

Topic::Topic(TopicContext& context, const google::protobuf::Message& message,
             std::function<void()> on_end)
    : context_(context),
      message_(message),
      on_end_(std::move(on_end)),
      feed_(std::make_shared<Feed>(*this)),
      flush_timer_(context.io),
      idle_timer_(context.io) {
  ++context_.counters.open_topic_count;
}

Topic::~Topic() {
  feed_->Close();
  --context_.counters.open_topic_count;
}

bool Topic::Open(const google::protobuf::Message& request, const std::string& caller,
                 const std::optional<std::string>& token) {
  return context_.begin_watch(request, caller, token, feed_);
}

void Topic::Join(std::shared_ptr<Exchange> exchange, WatcherShare share) {
  idle_timer_.cancel();
  Flush();
  if (const SharedText missed = MissedSince(exchange->request().Header("Last-Event-ID")))
    return Begin(*exchange, std::move(share), {missed});
  if (snapshot_) return Begin(*exchange, std::move(share), {snapshot_});
  waiting_.emplace_back(std::move(exchange), std::move(share));
  WantSnapshot();
}

void Topic::Begin(Exchange& exchange, WatcherShare share, const std::vector<SharedText>& texts) {
  auto watcher = std::make_unique<Watcher>(*this, std::move(share));
  watchers_.insert(watcher.get());
  for (const SharedText& text : texts) watcher->Push(text);
  exchange.Stream({"text/event-stream"}, std::move(watcher));
}

SharedText Topic::MissedSince(std::string_view id) const {
  const auto seen = std::find_if(kept_.begin(), kept_.end(),
                                 [id](const KeptMessage& message) { return message.id == id; });
  if (seen == kept_.end()) return nullptr;
  std::string missed = kComment;
  for (auto next = std::next(seen); next != kept_.end(); ++next) missed += next->text;
  return Shared(std::move(missed));
}

void Topic::WantSnapshot() {
  if (!std::exchange(snapshot_wanted_, true)) feed_->WantSnapshot();
}

void Topic::OnBatch(const Batch& batch) {
  for (const events::EventPtr& event : batch.events) {
    const std::string id = IdOf(event->stamp);
    const std::string text = absl::StrCat("id: ", id, "\n", DataOf(JsonOf(*event)));
    Keep(id, text);
    Add(text);
    snapshot_.reset();
  }
  if (!batch.snapshot) return;
  Flush();
  if (batch.snapshot->replaces_all) DropState();
  making_ = Making{.snapshot = *batch.snapshot, .text = kSnapshotBegin};
  Keep(IdOf(making_->snapshot.stamp), "");
  MakeSnapshot();
}

void Topic::DropState() {
  snapshot_.reset();
  kept_.clear();
  kept_bytes_ = 0;
  for (Watcher* watcher : watchers_) watcher->AwaitSnapshot();
}

void Topic::MakeSnapshot() {
  const auto& events = making_->snapshot.events;
  const size_t end = std::min(making_->next + kEventsAtOnce, events.size());
  for (; making_->next < end; ++making_->next)
    making_->text += DataOf(JsonOf(*events[making_->next]));
  if (making_->text.size() > context_.limits.max_snapshot_bytes) {
    return OnEnd(absl::ResourceExhaustedError(
        "the selection is too large to show at once; watch one project or scene"));
  }
  if (end == events.size()) return HandOutSnapshot();
  boost::asio::post(context_.io, [weak = weak_from_this()] {
    if (const auto self = weak.lock(); self && self->making_) self->MakeSnapshot();
  });
}

void Topic::HandOutSnapshot() {
  Flush();
  Making made = *std::exchange(making_, std::nullopt);
  snapshot_wanted_ = false;
  absl::StrAppend(&made.text, "id: ", IdOf(made.snapshot.stamp),
                  "\nevent: snapshot-end\ndata: {}\n\n");
  std::vector<SharedText> texts = {Shared(std::move(made.text))};
  if (made.later.empty()) {
    snapshot_ = texts.front();
  } else {
    texts.push_back(Shared(std::move(made.later)));
  }
  for (Watcher* watcher : watchers_) {
    if (watcher->wants_snapshot()) watcher->PushSnapshot(texts);
  }
  for (auto& [exchange, share] : std::exchange(waiting_, {}))
    Begin(*exchange, std::move(share), texts);
}

const std::string& Topic::JsonOf(const events::Event& event) {
  if (!event.json.empty()) return event.json;
  const std::unique_ptr<google::protobuf::Message> message(message_.New());
  message->ParseFromString(*event.body + event.tail);
  // Cannot fail: the daemon encoded the message itself.
  event.json = ToJson(*message).value_or("{}");
  ++context_.counters.encoded_count;
  return event.json;
}

void Topic::OnEnd(const absl::Status& status) {
  making_.reset();
  const absl::Status why =
      status.ok() ? absl::UnavailableError("the daemon ended the stream; watch again") : status;
  for (auto& [exchange, share] : std::exchange(waiting_, {})) exchange->Answer(ErrorPage(why));
  Flush();
  const SharedText text = Shared("event: error\n" + DataOf(ErrorJson(why)));
  for (Watcher* watcher : std::exchange(watchers_, {})) watcher->End(text);
  Close();
}

void Topic::Close() {
  feed_->Close();
  on_end_();
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
  const SharedText text = Shared(std::exchange(added_, {}));
  if (making_) making_->later += *text;
  for (Watcher* watcher : watchers_) watcher->Push(text);
}

void Topic::Beat() {
  static const SharedText comment = Shared(kComment);
  for (Watcher* watcher : watchers_) watcher->Beat(comment);
}

void Topic::Leave(Watcher& watcher) {
  watchers_.erase(&watcher);
  if (!idle()) return;
  idle_timer_.expires_after(context_.limits.idle_patience);
  idle_timer_.async_wait([weak = weak_from_this()](boost::system::error_code cancelled) {
    // A watcher may have joined after the timer expired and before this handler ran.
    if (const auto self = weak.lock(); self && !cancelled && self->idle()) self->Close();
  });
}

}  // namespace sweepstake::web
