// Tests the webhook with a real HTTP server and a clock that the test advances.
#include "server/alerts/webhook.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "tests/server/alerts/webhook_receiver.h"
#include "tests/server/sessions/manual_clock.h"

namespace sweepstake::alerts {
namespace {

using ::testing::HasSubstr;

class WebhookTest : public ::testing::Test {
 protected:
  template <typename Condition>
  static bool Eventually(Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }
  bool Failed(uint64_t count) {
    return Eventually([&] { return webhook_.counters().failed_count == count; });
  }
  bool Delivered(uint64_t count) {
    return Eventually([&] {
      return webhook_.counters().delivered_count == count && webhook_.counters().queued_count == 0;
    });
  }
  std::string problems() {
    const std::lock_guard lock(mutex_);
    return problems_;
  }

  sessions::ManualClock clock_;
  WebhookReceiver receiver_;
  std::mutex mutex_;
  std::string problems_;  // guarded by mutex_
  Webhook webhook_{{.user_agent = "sweepstaked/test",
                    .on_problem =
                        [this](const std::string& problem) {
                          const std::lock_guard lock(mutex_);
                          problems_ += problem + "\n";
                        }},
                   clock_};
};

TEST_F(WebhookTest, MessagesArriveInTheirOrderAsJsonPosts) {
  webhook_.SetUrl(receiver_.url());
  webhook_.Post("{\"a\":1}");
  webhook_.Post("{\"a\":2}");
  const auto requests = receiver_.Await(2);
  EXPECT_EQ(requests[0].method, "POST");
  EXPECT_EQ(requests[0].target, "/alerts?a=b");
  EXPECT_EQ(requests[0].content_type, "application/json");
  EXPECT_EQ(requests[0].user_agent, "sweepstaked/test");
  EXPECT_EQ(requests[0].body, "{\"a\":1}");
  EXPECT_EQ(requests[1].body, "{\"a\":2}");
  EXPECT_TRUE(Delivered(2));
}

TEST_F(WebhookTest, AFailedMessageIsSentAgainAfterAGrowingWait) {
  receiver_.AnswerWith({500, WebhookReceiver::kNoAnswer, 404});
  webhook_.SetUrl(receiver_.url());
  webhook_.Post("1");
  webhook_.Post("2");
  ASSERT_TRUE(Failed(1));
  EXPECT_EQ(receiver_.request_count(), 1u);
  clock_.Advance(Webhook::kFirstWaitNs);
  ASSERT_TRUE(Failed(2));
  clock_.Advance(2 * Webhook::kFirstWaitNs);
  ASSERT_TRUE(Failed(3));
  clock_.Advance(4 * Webhook::kFirstWaitNs - 1);
  webhook_.Post("3");  // wakes the thread before the wait is over
  EXPECT_EQ(webhook_.counters().queued_count, 3u);
  EXPECT_EQ(receiver_.request_count(), 3u);
  clock_.Advance(1);
  const auto requests = receiver_.Await(6);
  EXPECT_EQ(requests[3].body, "1");
  EXPECT_EQ(requests[4].body, "2");
  EXPECT_EQ(requests[5].body, "3");
  EXPECT_TRUE(Delivered(3));
}

TEST_F(WebhookTest, AMessageIsDroppedAfterTenAttempts) {
  receiver_.AnswerWith(std::deque<int>(Webhook::kMaxAttempts, 503));
  webhook_.SetUrl(receiver_.url());
  webhook_.Post("lost");
  webhook_.Post("next");
  for (uint32_t i = 1; i <= Webhook::kMaxAttempts; ++i) {
    ASSERT_TRUE(Failed(i));
    clock_.Advance(Webhook::kMaxWaitNs);
  }
  EXPECT_TRUE(Delivered(1));
  EXPECT_EQ(receiver_.Await(Webhook::kMaxAttempts + 1).back().body, "next");
  EXPECT_EQ(webhook_.counters().dropped_count, 1u);
}

TEST_F(WebhookTest, ProblemsAreReportedAtMostOncePerMinute) {
  receiver_.AnswerWith({500, 501, 502});
  webhook_.SetUrl(receiver_.url());
  webhook_.Post("1");
  ASSERT_TRUE(Failed(1));
  clock_.Advance(Webhook::kFirstWaitNs);
  ASSERT_TRUE(Failed(2));
  clock_.Advance(Webhook::kReportIntervalNs);
  ASSERT_TRUE(Failed(3));
  EXPECT_TRUE(Eventually([this] {
    return problems() ==
           "the receiver answered with the status 500\n"
           "the receiver answered with the status 502\n";
  })) << problems();
}

TEST_F(WebhookTest, ARedirectIsAFailureAndIsNotFollowed) {
  receiver_.AnswerWith({307});
  webhook_.SetUrl(receiver_.url());
  webhook_.Post("1");
  ASSERT_TRUE(Failed(1));
  EXPECT_EQ(receiver_.request_count(), 1u);
}

TEST_F(WebhookTest, OnlyHttpIsSpoken) {
  webhook_.SetUrl("file:///etc/hostname");
  webhook_.Post("1");
  ASSERT_TRUE(Failed(1));
  EXPECT_TRUE(Eventually([this] { return !problems().empty(); }));
}

TEST_F(WebhookTest, AServerWithoutACertificateIsRefused) {
  webhook_.SetUrl("https://127.0.0.1:" + std::to_string(receiver_.port()) + "/");
  webhook_.Post("1");
  ASSERT_TRUE(Failed(1));
  EXPECT_EQ(receiver_.request_count(), 0u);
}

TEST_F(WebhookTest, WithoutAUrlMessagesAreIgnored) {
  webhook_.Post("ignored");
  webhook_.SetUrl(receiver_.url());
  webhook_.Post("sent");
  EXPECT_EQ(receiver_.Await(1)[0].body, "sent");
}

TEST_F(WebhookTest, ANewUrlIsUsedAtOnceAndAnEmptyOneDropsWhatWaits) {
  WebhookReceiver other;
  receiver_.AnswerWith({500});
  webhook_.SetUrl(receiver_.url());
  webhook_.Post("1");
  ASSERT_TRUE(Failed(1));
  webhook_.SetUrl(other.url());
  EXPECT_EQ(other.Await(1)[0].body, "1");
  ASSERT_TRUE(Delivered(1));
  other.AnswerWith({500});
  webhook_.Post("2");
  ASSERT_TRUE(Failed(2));
  webhook_.SetUrl("");
  EXPECT_EQ(webhook_.counters().queued_count, 0u);
  EXPECT_EQ(webhook_.counters().dropped_count, 1u);
}

TEST_F(WebhookTest, AFullQueueDropsTheOldestMessage) {
  receiver_.AnswerWith({500});
  webhook_.SetUrl(receiver_.url());
  webhook_.Post("0");
  ASSERT_TRUE(Failed(1));
  for (size_t i = 1; i <= Webhook::kMaxQueued; ++i) webhook_.Post(std::to_string(i));
  EXPECT_EQ(webhook_.counters().queued_count, Webhook::kMaxQueued);
  EXPECT_EQ(webhook_.counters().dropped_count, 1u);
  clock_.Advance(Webhook::kFirstWaitNs);
  EXPECT_EQ(receiver_.Await(2)[1].body, "1");
}

TEST_F(WebhookTest, AnUnreachableReceiverIsAFailure) {
  std::string url;
  {
    const WebhookReceiver closed;
    url = closed.url();
  }
  webhook_.SetUrl(url);
  webhook_.Post("1");
  ASSERT_TRUE(Failed(1));
  EXPECT_TRUE(Eventually([this] { return problems().find("connect") != std::string::npos; }))
      << problems();
}

}  // namespace
}  // namespace sweepstake::alerts
