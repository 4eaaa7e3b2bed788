// Tests the pages /livez and /readyz.
#include "server/web/health_page.h"

#include <gtest/gtest.h>

namespace sweepstake::web {
namespace {

class HealthPageTest : public ::testing::Test {
 protected:
  Page ReadyPage(std::string_view query = "") {
    return HealthPage(
        "readyz",
        {{"store", [this] { return store_problem_; }}, {"shutdown", [] { return std::nullopt; }}},
        query);
  }

  std::optional<std::string> store_problem_;
};

TEST_F(HealthPageTest, ChecksWithoutAProblemAreOk) {
  EXPECT_EQ(ReadyPage().status, 200);
  EXPECT_EQ(ReadyPage().body, "ok\n");
}

TEST_F(HealthPageTest, TheVerboseListHasEveryCheck) {
  EXPECT_EQ(ReadyPage("verbose").status, 200);
  EXPECT_EQ(ReadyPage("verbose").body, "[+]store ok\n[+]shutdown ok\nreadyz check passed\n");
}

TEST_F(HealthPageTest, AProblemIs503AndIsAlwaysListed) {
  store_problem_ = "the disk is full";
  EXPECT_EQ(ReadyPage().status, 503);
  EXPECT_EQ(ReadyPage().body,
            "[-]store failed: the disk is full\n[+]shutdown ok\nreadyz check failed\n");
}

}  // namespace
}  // namespace sweepstake::web
