// Fuzzes a link: the bytes determine what the daemon and the owner of the stream send, in which
// order, how a stream ends, and how time passes.
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine_client/telemetry/protocol/messages.h"
#include "engine_client/telemetry/protocol/session_link.h"
#include "sweepstake/v1/telemetry.pb.h"
#include "tests/fuzz/input.h"

namespace sweepstake {
namespace {

using fuzz::Input;
using fuzz::Require;

// Returns an AdaptiveBroadPhase that all inputs share. It runs no frames, so its arm, switch epoch
// and mode never change.
AdaptiveBroadPhase& Adaptive() {
  static const std::unique_ptr<AdaptiveBroadPhase> kMade = std::move(*AdaptiveBroadPhase::Create(
      {.arms = {"BruteForce", "Grid"}, .shadow = {.enabled = ShadowMode::kOff}}, nullptr));
  return *kMade;
}

SessionOptions Options() {
  SessionOptions options;
  options.batch_frames = 3;
  options.unacknowledged_messages = 8;
  options.allow_operator_orders = true;
  options.allow_box_view = true;
  return options;
}

class Owner {
 public:
  void Do(Input& input) {
    switch (input.Byte() % 8) {
      case 0:
        return PushFrames(input.Byte() % 16, input.Byte());
      case 1:
        return Connect();
      case 2:
        return Receive(std::string(input.Piece()));
      case 3:
        return Disconnect(input.Byte() % 20, std::string(input.Piece()));
      case 4:
        now_ns_ += input.TwoBytes() * kNsPerMs;
        break;
      case 5:
        if (input.Byte() == 0) link_.Goodbye(now_ns_ + input.TwoBytes() * kNsPerMs);
        break;
      default:
        Advance();
    }
  }

  void CheckStats() const {
    const SessionStats stats = link_.stats();
    Require(stats.acknowledged_sequence <= stats.sent_sequence, "acknowledged messages were sent");
    Require(stats.sent_frame_count <= next_frame_, "a frame is counted once");
    Require(stats.beliefs.empty() || stats.beliefs.size() == 2, "a belief for each arm");
  }

 private:
  void PushFrames(int count, uint8_t flags) {
    for (int i = 0; i < count; ++i) {
      FrameSample sample{};
      sample.frame_index = next_frame_++;
      sample.flags = flags;
      queue_.OnFrame(sample);
    }
  }

  void Connect() {
    if (link_.connected() || link_.finished()) return;
    link_.Connected(now_ns_);
    message_count_ = 0;
    last_sequence_.reset();
    finished_ = cancelled_ = false;
  }

  void Receive(const std::string& bytes) {
    const Status status = link_.OnMessage(bytes, now_ns_);
    if (status.code() != StatusCode::kDataLoss) return;
    Require(link_.Advance(now_ns_) == LinkAction::kCancel, "a broken message ends the stream");
  }

  void Disconnect(uint32_t code, std::string details) {
    link_.Disconnected({.code = code, .message = "end", .details = std::move(details)}, now_ns_);
    cancelled_ = false;
  }

  void Advance() {
    const LinkAction action = link_.Advance(now_ns_);
    Require(!cancelled_ || action == LinkAction::kCancel,
            "a cancelled stream stays cancelled until it has ended");
    cancelled_ = action == LinkAction::kCancel;
    if (action == LinkAction::kFinish) {
      Require(!finished_, "a stream is finished once");
      finished_ = link_.Take(now_ns_).empty();
    }
    if (action == LinkAction::kSend) CheckMessage(link_.Take(now_ns_));
  }

  void CheckMessage(const std::string& bytes) {
    Require(!finished_, "nothing comes after the end");
    Require(request_.ParseFromString(bytes), "protobuf can parse each message");
    Require((message_count_++ == 0) == request_.has_hello(), "a stream begins with its Hello");
    if (request_.has_hello() || request_.has_goodbye()) return;
    Require(request_.sequence() > 0, "evidence has a sequence number");
    // If the daemon acknowledges messages that were not sent on this stream, the numbers continue
    // after them.
    Require(!last_sequence_ || request_.sequence() > *last_sequence_, "numbers ascend");
    last_sequence_ = request_.sequence();
  }

  SampleQueue queue_{64};
  SessionLink link_{Options(), "the daemon", 1, queue_, Adaptive()};
  v1::StreamTelemetryRequest request_;
  uint64_t now_ns_ = kNsPerMs;
  uint64_t next_frame_ = 0;
  uint64_t message_count_ = 0;
  std::optional<uint64_t> last_sequence_;
  bool finished_ = false;
  bool cancelled_ = false;
};

}  // namespace
}  // namespace sweepstake

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sweepstake::fuzz::Input input(data, size);
  sweepstake::Owner owner;
  while (!input.empty()) {
    owner.Do(input);
    owner.CheckStats();
  }
  return 0;
}
