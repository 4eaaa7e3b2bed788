// Tests a game on the C ABI with its own transport: a gRPC stream moves the bytes of a link to and
// from the real daemon without parsing them.
#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine_client/telemetry/daemon_connection.h"
#include "engine_client/telemetry/protocol/messages.h"
#include "sweepstake/c_api.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake {
namespace {

using test_support::DaemonProcess;
using test_support::TemporaryDirectory;

// Calls the link every 5 ms or more often, as c_link.h requires.
class LinkHost {
 public:
  explicit LinkHost(std::string address) : address_(std::move(address)) {
    swp_session_options session{};
    session.struct_size = sizeof session;
    EXPECT_EQ(swp_session_options_init(&session), SWP_OK);
    session.shadow = SWP_SHADOW_OFF;  // so that the evidence depends on the frames alone
    session.arms = "SAP,Grid,DBVT";
    EXPECT_EQ(swp_session_create(&session, &session_), SWP_OK);
    swp_link_options options{};
    options.struct_size = sizeof options;
    EXPECT_EQ(swp_link_options_init(&options), SWP_OK);
    options.daemon = address_.c_str();
    options.scene = "c link";
    options.time_scale = 200;
    options.batch_frames = 10;
    options.backoff_min_ms = 1;
    options.backoff_max_ms = 20;
    EXPECT_EQ(swp_link_create(session_, &options, &link_), SWP_OK);
  }
  ~LinkHost() {
    swp_link_destroy(link_);
    swp_session_destroy(session_);
  }
  LinkHost(const LinkHost&) = delete;
  LinkHost& operator=(const LinkHost&) = delete;

  // Runs one frame, then moves the bytes that wait in the link and in the stream.
  void Step() {
    const std::vector<swp_aabb> boxes(50, {{0, 0, 0}, {1, 1, 1}});
    EXPECT_EQ(swp_session_begin_frame(session_), SWP_OK);
    EXPECT_EQ(swp_session_find_pairs(session_, boxes.data(), 50), SWP_OK);
    EXPECT_EQ(swp_session_end_frame(session_, 16 * kNsPerMs, 0), SWP_OK);
    Move();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  void Goodbye() { EXPECT_EQ(swp_link_goodbye(link_, Now() + 60'000 * kNsPerMs), SWP_OK); }

  swp_link_stats stats() const {
    swp_link_stats stats{};
    stats.struct_size = sizeof stats;
    EXPECT_EQ(swp_link_status(link_, &stats), SWP_OK);
    return stats;
  }
  std::string text(swp_link_text which) const {
    char text[1024];
    uint64_t size = 0;
    EXPECT_EQ(swp_link_copy_text(link_, which, text, sizeof text, &size), SWP_OK);
    return {text, size};
  }
  uint32_t switch_epoch() const {
    uint32_t epoch = 0;
    EXPECT_EQ(swp_session_switch_epoch(session_, &epoch), SWP_OK);
    return epoch;
  }

 private:
  static uint64_t Now() { return SteadyClock().NowNs(); }

  void Move() {
    if (!stream_ && Now() >= next_attempt_ns_) {
      stream_.emplace(*DaemonConnection::MakeChannel(address_, {}, {}, {}), [] {});
      EXPECT_EQ(swp_link_connected(link_, Now()), SWP_OK);
    }
    if (stream_) Read();
    Write();
  }

  void Read() {
    while (const auto message = stream_->TakeResponse())
      EXPECT_EQ(swp_link_on_message(link_, message->data(), message->size(), Now()), SWP_OK);
    const std::optional<grpc::Status> status = stream_->closed();
    if (!status) return;
    stream_.reset();
    uint32_t delay_ms = 0;
    EXPECT_EQ(swp_link_disconnected(link_, static_cast<uint32_t>(status->error_code()),
                                    status->error_message().c_str(), status->error_details().data(),
                                    status->error_details().size(), Now(), &delay_ms),
              SWP_OK);
    next_attempt_ns_ = delay_ms == SWP_LINK_NEVER ? UINT64_MAX : Now() + delay_ms * kNsPerMs;
  }

  void Write() {
    const bool writable = stream_ && stream_->writable();
    uint64_t size = 0;
    swp_link_action action = SWP_LINK_NONE;
    const swp_result result =
        swp_link_next_message(link_, Now(), writable ? buffer_.data() : nullptr,
                              writable ? buffer_.size() : 0, &size, &action);
    if (result == SWP_RESOURCE_EXHAUSTED) return;  // A write is in progress.
    EXPECT_EQ(result, SWP_OK);
    finish_ = finish_ || action == SWP_LINK_FINISH;
    if (action == SWP_LINK_SEND) stream_->Write({buffer_.data(), size});
    if (action == SWP_LINK_CANCEL && stream_) stream_->Cancel();
    if (finish_ && stream_ && stream_->writable()) {
      stream_->HalfClose();
      finish_ = false;
    }
  }

  const std::string address_;
  swp_session* session_ = nullptr;
  swp_link* link_ = nullptr;
  std::optional<DaemonConnection> stream_;
  std::vector<char> buffer_ = std::vector<char>(1 << 16);
  uint64_t next_attempt_ns_ = 0;
  bool finish_ = false;
};

TEST(LinkTest, PlaysAWholeSessionOverATransportThatDoesNotParseMessages) {
  const TemporaryDirectory folder;
  // "paper" draws at each decision, so a switch does not depend on the measured times.
  DaemonProcess daemon(folder.path(), "127.0.0.1:0", {"--decision-policy", "paper"});
  LinkHost host(daemon.address());
  while (host.stats().command_count == 0 || host.switch_epoch() == 0) host.Step();
  EXPECT_NE(host.text(SWP_LINK_SESSION_ID), "");
  host.Goodbye();
  while (host.stats().state != SWP_LINK_CLOSED) host.Step();
  EXPECT_EQ(host.text(SWP_LINK_LAST_ERROR), "");
  EXPECT_EQ(host.stats().resent_message_count, 0U);
}

TEST(LinkTest, ResumesWithADaemonThatWasKilled) {
  const TemporaryDirectory folder;
  std::optional<DaemonProcess> daemon(std::in_place, folder.path());
  const std::string address = daemon->address();
  LinkHost host(address);
  while (host.stats().acknowledged_sequence == 0) host.Step();
  const std::string session = host.text(SWP_LINK_SESSION_ID);
  daemon->Kill();
  while (host.stats().state == SWP_LINK_ONLINE) host.Step();
  EXPECT_NE(host.text(SWP_LINK_LAST_ERROR), "");
  daemon.emplace(folder.path(), address);
  while (host.stats().resumed_count == 0) host.Step();
  EXPECT_EQ(host.text(SWP_LINK_SESSION_ID), session);
  const uint64_t sent = host.stats().sent_sequence;
  while (host.stats().acknowledged_sequence < sent) host.Step();
}

}  // namespace
}  // namespace sweepstake
