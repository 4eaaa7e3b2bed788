#include "server/rpc/common/refusal_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/ostream_sink.h>

#include <functional>
#include <memory>
#include <sstream>
#include <thread>
#include <utility>

#include "server/rpc/common/error_reasons.h"
#include "tests/server/sessions/manual_clock.h"

namespace sweepstake::rpc {
namespace {

class RefusalLogTest : public ::testing::Test {
 protected:
  RefusalLogTest() { log_.set_pattern("%v"); }
  void Refuse(v1::ErrorReason reason, int count) {
    for (int i = 0; i < count; ++i) refusals_.Tell("ipv4:192.0.2.7:1", Refused(reason, "no"));
  }
  // Returns the text that was logged since the last call.
  std::string Said() {
    std::string said = text_.str();
    text_.str("");
    return said;
  }

  std::ostringstream text_;
  spdlog::logger log_{"test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)};
  sessions::ManualClock clock_;
  RefusalLog refusals_{clock_, log_};
};

TEST_F(RefusalLogTest, LogsOneLinePerReasonAndTheNumberOfOmittedLines) {
  Refuse(v1::ERROR_REASON_INVALID_MESSAGE, 1'000);
  Refuse(v1::ERROR_REASON_MESSAGE_ORDER, 1);
  EXPECT_EQ(Said(),
            "refused ipv4:192.0.2.7:1 (INVALID_MESSAGE): no\n"
            "refused ipv4:192.0.2.7:1 (MESSAGE_ORDER): no\n");
  clock_.Advance(RefusalLog::kIntervalNs - 1);
  refusals_.TellLeftOut();
  EXPECT_EQ(Said(), "");
  clock_.Advance(1);
  refusals_.TellLeftOut();
  EXPECT_EQ(Said(), "refused 999 more calls (INVALID_MESSAGE)\n");
  clock_.Advance(10 * RefusalLog::kIntervalNs);
  refusals_.TellLeftOut();
  EXPECT_EQ(Said(), "") << "no line was omitted";
  Refuse(v1::ERROR_REASON_INVALID_MESSAGE, 1);
  EXPECT_EQ(Said(), "refused ipv4:192.0.2.7:1 (INVALID_MESSAGE): no\n");
}

// A sink that calls a function while it writes a line.
class BusySink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  std::function<void()> meanwhile;

 private:
  void sink_it_(const spdlog::details::log_msg& /*line*/) override {
    if (meanwhile) std::exchange(meanwhile, nullptr)();
  }
  void flush_() override {}
};

TEST(RefusalLogLockTest, CallsAreRefusedWhileALineIsWritten) {
  const auto sink = std::make_shared<BusySink>();
  spdlog::logger log("test", sink);
  sessions::ManualClock clock;
  RefusalLog refusals(clock, log);
  const auto refuse = [&] {
    refusals.Tell("ipv4:192.0.2.7:1", Refused(v1::ERROR_REASON_MESSAGE_ORDER, "no"));
  };
  refuse();
  refuse();
  clock.Advance(RefusalLog::kIntervalNs);
  int refused_meanwhile_count = 0;
  sink->meanwhile = [&] {
    std::thread(refuse).join();  // blocks forever if the lock is held
    ++refused_meanwhile_count;
  };
  refusals.TellLeftOut();
  EXPECT_EQ(refused_meanwhile_count, 1);
}

}  // namespace
}  // namespace sweepstake::rpc
