#include "tests/server/simulation/connection.h"

#include <algorithm>
#include <utility>

namespace sweepstake::simulation {

void Connection::Later(int64_t delay_ns, StreamEvent event) {
  world_.After(delay_ns, [weak = weak_from_this(), event = std::move(event)] {
    if (const auto self = weak.lock()) event(*self);
  });
}

void Connection::ToDaemon(StreamEvent event) {
  last_to_daemon_ns_ =
      std::max(last_to_daemon_ns_, world_.NowNs() + world_.Draw(kMsNs / 10, 40 * kMsNs));
  Later(last_to_daemon_ns_ - world_.NowNs(), [event = std::move(event)](Connection& self) {
    if (self.stream_ && !self.lost_) event(self);
  });
}

void Connection::ToGame(StreamEvent event) {
  last_to_game_ns_ =
      std::max(last_to_game_ns_, world_.NowNs() + world_.Draw(kMsNs / 10, 40 * kMsNs));
  Later(last_to_game_ns_ - world_.NowNs(), [event = std::move(event)](Connection& self) {
    if (self.user_ != nullptr) event(self);
  });
}

void Connection::Post(StreamEvent event) {
  loop_->Post([weak = weak_from_this(), event = std::move(event)] {
    if (const auto self = weak.lock(); self && self->stream_) event(*self);
  });
}

void Connection::Dial(std::function<void(Connection&)> answer) {
  const int64_t delay_ns = world_.Draw(kMsNs / 10, 40 * kMsNs);
  last_to_daemon_ns_ = world_.NowNs() + delay_ns;
  Later(delay_ns, std::move(answer));
}

void Connection::Refuse(const absl::Status& status) { Close(status); }

void Connection::Send(const v1::StreamTelemetryRequest& request) {
  ToDaemon([request](Connection& self) {
    self.arrived_.push_back(request);
    self.Deliver();
  });
}

void Connection::HalfClose() {
  ToDaemon([](Connection& self) {
    self.ended_ = true;
    self.Deliver();
  });
}

void Connection::Break() {
  Later(world_.Draw(0, 10 * kMsNs),
        [](Connection& self) { self.Close(absl::UnavailableError("the connection broke")); });
  // A daemon may notice late that a game no longer sends.
  const int64_t delay_ns = world_.Draw(0, world_.Happens(0.5) ? 20 * kMsNs : 8 * kSecondNs);
  Later(delay_ns, [](Connection& self) {
    if (self.stream_) self.Lose();
  });
}

void Connection::Cut() {
  const auto self = shared_from_this();  // the game releases its pointer
  Close(absl::UnavailableError("the connection broke"));
  Break();
}

void Connection::Close(const absl::Status& status) {
  if (ConnectionUser* user = std::exchange(user_, nullptr)) user->OnClosed(status);
}

void Connection::Open(rpc::ServiceContext& context, rpc::TelemetryStreams& streams,
                      auth::Principal caller) {
  loop_ = &context.loop;
  stream_ = std::make_shared<rpc::TelemetryStream>(context, streams, *this, std::move(caller));
  Post([](Connection& self) { self.stream_->Accept(); });
}

void Connection::Die() {
  stream_.reset();
  Later(world_.Draw(0, 50 * kMsNs),
        [](Connection& self) { self.Close(absl::UnavailableError("the daemon died")); });
}

void Connection::Read() {
  if (++pending_reads_ > kMaxReads) std::abort();
  Deliver();
}

void Connection::Deliver() {
  for (; pending_reads_ > 0 && !arrived_.empty(); --pending_reads_) {
    Post([read = std::move(arrived_.front())](Connection& self) mutable {
      self.stream_->OnMessage(&read);
    });
    arrived_.pop_front();
  }
  if (!ended_ || pending_reads_ == 0 || std::exchange(told_end_, true)) return;
  Post([](Connection& self) { self.stream_->OnHalfClose(); });
}

void Connection::Write(const v1::StreamTelemetryResponse& response) {
  writing_ = true;
  if (!lost_) ToGame([response](Connection& self) { self.user_->OnResponse(response); });
  Later(lost_ ? 0 : world_.Draw(0, 5 * kMsNs), [](Connection& self) {
    if (!self.stream_ || !std::exchange(self.writing_, false)) return;
    self.Post([ok = !self.lost_](Connection& written) { written.stream_->OnWritten(ok); });
  });
}

void Connection::Lose() {
  if (std::exchange(lost_, true)) return;
  ended_ = true;
  arrived_.clear();
  Deliver();
  if (std::exchange(writing_, false))
    Post([](Connection& self) { self.stream_->OnWritten(false); });
  Post([](Connection& self) { self.stream_->OnCancelled(); });
}

void Connection::Cancel(const absl::Status& status) {
  ToGame([status](Connection& self) { self.Close(status); });
  Lose();
}

void Connection::Finish(const absl::Status& status) {
  ToGame([status](Connection& self) { self.Close(status); });
  ended_ = true;
  arrived_.clear();
  Deliver();
  Post([](Connection& self) {
    self.stream_->OnDone();
    self.stream_.reset();
  });
}

}  // namespace sweepstake::simulation
