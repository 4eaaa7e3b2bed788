// Tests the reports about the TLS files of a running daemon.
#include "server/tls/files_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::tls {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int64_t kOneDayS = 86'400;

class FilesWatchTest : public ::testing::Test {
 protected:
  FilesWatchTest() { Issue(30 * kOneDayS); }

  std::filesystem::path Path(const std::string& name) const { return folder_.path() / name; }
  void Issue(int64_t expires_in_s) {
    authority_.Issue("IP:127.0.0.1", {files_.cert, files_.key}, expires_in_s);
  }
  void Start() {
    watch_.emplace(files_,
                   FilesWatchOptions{.own_thread = false,
                                     .unix_now_s = [this] { return now_s_; },
                                     .on_change =
                                         [this](const absl::Status& status, int64_t expires) {
                                           told_.emplace_back(status.message());
                                           expires_unix_s_ = expires;
                                         },
                                     .on_expiry = [this](int64_t) { ++expiry_count_; }});
  }
  // Performs `count` checks, and returns their reports.
  std::vector<std::string> Look(int count) {
    told_.clear();
    for (int i = 0; i < count; ++i) watch_->Look();
    return told_;
  }

  test_support::TemporaryDirectory folder_;
  test_support::TestAuthority authority_{Path("ca.pem")};
  Files files_{.cert = Path("cert.pem"), .key = Path("key.pem"), .ca = authority_.cert()};
  const int64_t start_s_ =
      std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
          .count();
  int64_t now_s_ = start_s_;
  std::vector<std::string> told_;  // reported problems; an empty string is an OK
  int64_t expires_unix_s_ = 0;
  int expiry_count_ = 0;
  std::optional<FilesWatch> watch_;
};

TEST_F(FilesWatchTest, OnlyTheFirstCheckReportsTheExpiryOfTheCertificate) {
  Start();
  EXPECT_THAT(told_, ::testing::ElementsAre(""));
  EXPECT_NEAR(expires_unix_s_, start_s_ + 30 * kOneDayS, 60);
  EXPECT_THAT(Look(10), IsEmpty());
  EXPECT_EQ(expiry_count_, 0);
}

TEST_F(FilesWatchTest, ReportsALastingProblemOnceAndItsEnd) {
  Start();
  const std::string whole = test_support::FileText(files_.cert);
  const int64_t expires_unix_s = expires_unix_s_;
  const std::vector<std::pair<std::string, std::string>> broken = {
      {"garbage", "contains no complete certificate"},
      {whole.substr(0, whole.size() / 2), "contains no complete certificate"},
      {test_support::FileText(authority_.cert()), "cannot be used together"}};
  for (const auto& [text, problem] : broken) {
    std::ofstream(files_.cert) << text;
    const auto told = Look(10);
    ASSERT_EQ(told.size(), 1u) << text;
    EXPECT_THAT(told[0], HasSubstr(problem));
    EXPECT_THAT(told[0], HasSubstr(files_.cert.string()));
    EXPECT_EQ(expires_unix_s_, expires_unix_s) << "the previous certificate is still in use";
    std::ofstream(files_.cert) << whole;
    EXPECT_THAT(Look(10), ::testing::ElementsAre(""));
  }
  std::filesystem::remove(files_.key);
  EXPECT_THAT(Look(10), ::testing::ElementsAre(HasSubstr("cannot read " + files_.key.string())));
  std::ofstream(files_.key) << "garbage";
  EXPECT_THAT(Look(10), ::testing::ElementsAre(HasSubstr("contains no unencrypted private key")));
}

TEST_F(FilesWatchTest, ACertificateReplacedBeforeItsKeyIsNotReported) {
  Start();
  const auto key = test_support::FileText(files_.key);
  Issue(60 * kOneDayS);
  const auto next_key = test_support::FileText(files_.key);
  std::ofstream(files_.key) << key;
  EXPECT_THAT(Look(1), IsEmpty());
  std::ofstream(files_.key) << next_key;
  EXPECT_THAT(Look(10), ::testing::ElementsAre(""));
  EXPECT_NEAR(expires_unix_s_, start_s_ + 60 * kOneDayS, 60);
}

TEST_F(FilesWatchTest, ReportsACertificateThatExpiresWithinAWeekDaily) {
  Start();
  now_s_ += 22 * kOneDayS;
  Look(2);
  EXPECT_EQ(expiry_count_, 0);
  now_s_ += kOneDayS + 60;
  Look(2);
  EXPECT_EQ(expiry_count_, 1);
  now_s_ += kOneDayS;
  Look(2);
  EXPECT_EQ(expiry_count_, 2);
  Issue(60 * kOneDayS);
  Look(2);
  EXPECT_EQ(expiry_count_, 2) << "the certificate was replaced";
}

TEST_F(FilesWatchTest, ReportsAnExpiredCertificateAtTheStart) {
  Issue(-60);
  Start();
  EXPECT_EQ(expiry_count_, 1);
}

TEST_F(FilesWatchTest, TheEarliestExpiryInAChainCounts) {
  const std::string issuer = test_support::FileText(authority_.cert());
  const std::string own = test_support::FileText(files_.cert);
  authority_.Issue("IP:127.0.0.1", {Path("soon.pem"), Path("soon-key.pem")}, kOneDayS);
  const std::string soon = test_support::FileText(Path("soon.pem"));
  EXPECT_NEAR(EarliestExpiryUnixS(own), start_s_ + 30 * kOneDayS, 60);
  EXPECT_NEAR(EarliestExpiryUnixS(own + soon), start_s_ + kOneDayS, 60);
}

}  // namespace
}  // namespace sweepstake::tls
