#include "server/rpc/services/watch_call.h"

#include <memory>
#include <utility>
#include <vector>

#include "server/net/peer_address.h"
#include "server/rpc/services/stall_sweep.h"

namespace sweepstake::rpc {
namespace {

using events::EventPtr;

// Returns a slice that keeps the bytes alive.
grpc::Slice SliceOf(const std::shared_ptr<const std::string>& bytes) {
  return {const_cast<char*>(bytes->data()), bytes->size(),
          [](void* held) { delete static_cast<std::shared_ptr<const std::string>*>(held); },
          new std::shared_ptr<const std::string>(bytes)};
}

grpc::ByteBuffer MessageOf(const std::vector<EventPtr>& events) {
  std::vector<grpc::Slice> slices;
  for (const EventPtr& event : events) slices.push_back(SliceOf(event->body));
  slices.emplace_back(events.back()->tail);
  return {slices.data(), slices.size()};
}

std::unique_ptr<google::protobuf::Message> NewRequest(events::Kind kind) {
  switch (kind) {
    case events::Kind::kPosteriors:
      return std::make_unique<v1::WatchPosteriorsRequest>();
    case events::Kind::kSessions:
      return std::make_unique<v1::WatchSessionsRequest>();
    case events::Kind::kBoxes:
      break;
  }
  return std::make_unique<v1::WatchBoxesRequest>();
}

// A watcher over gRPC. When a message has been written, it takes the next events from its
// subscriber. It is used on the loop; gRPC's callbacks run on gRPC's threads and only post to the
// loop. The object deletes itself after OnDone.
class WatchCall final : public grpc::ServerGenericBidiReactor,
                        public StallingCall,
                        public events::Sink {
 public:
  WatchCall(ServiceContext& context, grpc::CallbackServerContext& call, events::Kind kind,
            Caller caller)
      : context_(context),
        call_(call),
        kind_(kind),
        caller_(std::move(caller)),
        max_events_(kind == events::Kind::kSessions ? kSessionsPerPage : 1) {
    StartRead(&message_);
  }

  void OnReadDone(bool ok) override {
    const std::unique_ptr<google::protobuf::Message> request = NewRequest(kind_);
    std::optional<events::Wish> wish;
    if (ok && Parse(message_, *request)) wish = WishOf(*request);
    context_.loop.Post([this, wish = std::move(wish)] { OnRequest(wish); });
  }

  void Begin(std::unique_ptr<events::Subscriber> subscriber) override {
    subscriber_ = std::move(subscriber);
  }
  void Wake() override {
    if (!writing_ && !end_) WriteNext();
  }
  // Ends the call. If a write is pending, cancels the call, so that the write fails.
  void OnEnd(const absl::Status& status) override {
    if (end_) return;
    end_ = status;
    context_.access.refusals().TellEnd(caller_.peer, status);
    subscriber_.reset();
    context_.stalls.Remove(*this);
    if (!writing_) return Finish(ToGrpc(status, context_.counters));
    Cancel(call_, ToGrpc(status, context_.counters));
    end_ = absl::CancelledError("the call was cut off");
  }

  int64_t waiting_since_ns() const override {
    return writing_ ? write_start_ns_ : sessions::LoopClock::kNever;
  }
  void OnStalled() override {
    OnEnd(Refused(v1::ERROR_REASON_WATCHER_STALLED,
                  "the watcher did not read its events in time; watch again"));
  }
  void OnWriteDone(bool ok) override {
    context_.loop.Post([this, ok] { OnWritten(ok); });
  }
  void OnCancel() override {
    context_.loop.Post([this] { OnEnd(absl::CancelledError("the connection was lost")); });
  }
  void OnDone() override {
    context_.loop.Post([this] { delete this; });  // after all tasks of this object
  }

 private:
  void WriteNext() {
    const std::vector<EventPtr> events = subscriber_->Take(max_events_);
    if (events.empty()) return;
    message_ = MessageOf(events);
    writing_ = true;
    write_start_ns_ = context_.loop.clock().NowNs();
    StartWrite(&message_);
  }

  void OnRequest(const std::optional<events::Wish>& wish) {
    if (end_) return;  // the client has left
    if (!wish && call_.IsCancelled()) return OnEnd(absl::CancelledError("the client has left"));
    if (!wish)
      return OnEnd(Refused(v1::ERROR_REASON_MALFORMED_MESSAGE, "the request does not parse"));
    context_.stalls.Add(*this);
    BeginWatch(context_, *wish, caller_, *this);
  }

  void OnWritten(bool ok) {
    writing_ = false;
    if (end_) return Finish(ToGrpc(*end_, context_.counters));
    if (!ok) return OnEnd(absl::CancelledError("the connection was lost"));
    WriteNext();
  }

  ServiceContext& context_;
  grpc::CallbackServerContext& call_;
  const events::Kind kind_;
  const Caller caller_;
  const size_t max_events_;  // maximum number of events in one message
  std::unique_ptr<events::Subscriber> subscriber_;
  grpc::ByteBuffer message_;  // the request, then the events
  bool writing_ = false;
  int64_t write_start_ns_ = 0;
  std::optional<absl::Status> end_;
};

}  // namespace

std::optional<events::Wish> WishOf(const google::protobuf::Message& request) {
  if (const auto* scenes = dynamic_cast<const v1::WatchPosteriorsRequest*>(&request)) {
    return events::Wish{.kind = events::Kind::kPosteriors,
                        .filter = {scenes->project(), scenes->scene()}};
  }
  if (const auto* sessions = dynamic_cast<const v1::WatchSessionsRequest*>(&request)) {
    return events::Wish{.kind = events::Kind::kSessions,
                        .filter = {sessions->project(), sessions->scene()}};
  }
  if (const auto* boxes = dynamic_cast<const v1::WatchBoxesRequest*>(&request)) {
    return events::Wish{.kind = events::Kind::kBoxes, .session_id = boxes->session_id()};
  }
  return std::nullopt;
}

Rpc RpcOf(events::Kind kind) {
  switch (kind) {
    case events::Kind::kPosteriors:
      return RpcOf("PosteriorsService/WatchPosteriors");
    case events::Kind::kSessions:
      return RpcOf("SessionsService/WatchSessions");
    case events::Kind::kBoxes:
      break;
  }
  return RpcOf("SessionsService/WatchBoxes");
}

std::optional<events::Kind> WatchedBy(std::string_view method) {
  for (const events::Kind kind :
       {events::Kind::kPosteriors, events::Kind::kSessions, events::Kind::kBoxes}) {
    if (RpcOf(kind).name == method) return kind;
  }
  return std::nullopt;
}

void BeginWatch(ServiceContext& context, events::Wish wish, const Caller& caller,
                events::Sink& sink) {
  const absl::Status allowed = Narrow(caller, wish.filter);
  auto share =
      allowed.ok() ? context.access.BeginWatch(caller, net::AddressOf(caller.peer)) : allowed;
  if (!share.ok()) {
    if (wish.on_end) wish.on_end(share.status());
    return sink.OnEnd(share.status());
  }
  auto& count = context.counters.open_watcher_count;
  ++count;
  wish.share = std::shared_ptr<void>(nullptr, [&count, share = *share](void*) { --count; });
  wish.check = [&access = context.access, caller] { return access.CheckStill(caller); };
  context.events.Subscribe(std::move(wish), sink);
}

grpc::ServerGenericBidiReactor* ServeWatch(ServiceContext& context,
                                           grpc::CallbackServerContext& call, events::Kind kind,
                                           Caller caller) {
  return new WatchCall(context, call, kind, std::move(caller));
}

}  // namespace sweepstake::rpc
