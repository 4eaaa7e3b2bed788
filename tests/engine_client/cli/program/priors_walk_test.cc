// Carries priors from build to build with the commands that deploy/OPERATING.md lists in its
// section Priors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/engine_client/cli/program/program.h"
#include "tests/support/daemon_process.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr char kGame[] =
    "run --scene suite-b --objects 100 --project arcade --scene-name arena --machine-class m ";

class PriorsWalk : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return (data_.path() / name).string(); }
  std::string at() const { return At(daemon_); }
  static std::string At(const test_support::DaemonProcess& daemon) {
    return " --daemon " + daemon.address();
  }
  static json JsonOf(const std::string& command) {
    const ProgramRun run = RunProgram(command + " --json");
    EXPECT_EQ(run.exit_code, 0) << command << ": " << run.err;
    return json::parse(run.out);
  }
  // Plays until something was learnt, which takes more than a second on a slow machine.
  json Play(const std::string& build) const {
    for (int seconds = 1;; seconds *= 2) {
      json run = JsonOf(kGame + std::string("--time-scale 1000 --duration ") +
                        std::to_string(seconds) + "s --build " + build + at());
      const bool has_learnt = std::any_of(run["arms"].begin(), run["arms"].end(),
                                          [](const json& arm) { return arm["live_windows"] > 0; });
      if (has_learnt || HasFailure()) return run;
    }
  }
  // Returns the daemon's evidence, to the last bit.
  std::string Known(const std::string& file) const {
    JsonOf("priors export --out " + Path(file) + at());
    return test_support::FileText(Path(file)) + JsonOf("priors list" + at()).dump();
  }

  test_support::TemporaryDirectory data_;
  test_support::DaemonProcess daemon_{data_.path()};
};

TEST_F(PriorsWalk, BuildsShareEvidenceABadBuildIsRevokedAndPriorsAreShipped) {
  EXPECT_EQ(Play("1.0")["prior_sources"], 0);
  const json second = Play("1.1");
  EXPECT_GE(second["prior_sources"], 1) << "it starts from what 1.0 has learnt";
  JsonOf("audit export --project arcade --out " + Path("log.csv") + at());
  EXPECT_THAT(test_support::FileText(Path("log.csv")),
              HasSubstr("of build 1.0 on m with weight 0.25"));

  const std::string before = Known("good.json");
  Play("1.2");
  EXPECT_NE(Known("with-1.2.json"), before);
  const json differences = JsonOf("priors diff " + Path("with-1.2.json") + " " +
                                  Path("with-1.2.json") + " --build 1.1 --other-build 1.2");
  EXPECT_TRUE(differences["scenes"].is_array());

  const std::string revoke = "priors revoke --project arcade --build 1.2" + at();
  const json preview = JsonOf(revoke);
  EXPECT_EQ(preview["revoked"], false);
  EXPECT_GE(preview["sources"], 1);
  EXPECT_NE(Known("previewed.json"), before);
  const json revoked = JsonOf(revoke + " --yes");
  EXPECT_EQ(revoked["revoked"], true);
  EXPECT_EQ(revoked["sources"], preview["sources"]);
  EXPECT_EQ(revoked["windows"], preview["windows"]);
  EXPECT_EQ(Known("without-1.2.json"), before);
  EXPECT_EQ(JsonOf("priors import --in " + Path("with-1.2.json") + at())["applied"], 0)
      << "an import does not restore revoked evidence";

  const json posteriors = JsonOf("priors list" + at())["scenes"];
  const std::string shipped = Path("shipped.json");
  EXPECT_EQ(JsonOf("priors export --sums --out " + shipped + at())["sums"], true);
  daemon_.Kill();
  EXPECT_THAT(RunProgram("priors show --in " + shipped).out, HasSubstr("arcade/arena on m"));
  const json doctor = JsonOf("priors doctor --machine-class m --build 1.1 --in " + shipped);
  EXPECT_EQ(doctor["entries"].size(), 2u) << "1.0 and 1.1";
  const std::string arm =
      JsonOf("priors arm --machine-class m --project arcade --scene arena --in " + shipped)["arm"];
  EXPECT_NE(arm, "");
  const json offline =
      JsonOf(kGame + std::string("--duration 200ms --embedded --build 1.1 --priors ") + shipped);
  EXPECT_GE(offline["prior_sources"], 2);
  EXPECT_EQ(offline["decider"], "embedded");

  const test_support::TemporaryDirectory other_data;
  const test_support::DaemonProcess other(other_data.path());
  EXPECT_GT(JsonOf("priors import --in " + Path("good.json") + At(other))["applied"], 0);
  const json waiting = JsonOf("priors list" + At(other));
  EXPECT_TRUE(waiting["scenes"].empty());
  EXPECT_EQ(waiting["quarantined"].size(), 2u) << "1.0 and 1.1";
  const std::string promote = "priors promote --project arcade" + At(other);
  const json promotion = JsonOf(promote);
  EXPECT_EQ(promotion["promoted"], false);
  EXPECT_EQ(promotion["sources"], 2);
  EXPECT_EQ(promotion["scenes"], 1);
  EXPECT_EQ(JsonOf("priors list" + At(other)), waiting) << "a preview";
  EXPECT_EQ(JsonOf(promote + " --yes")["windows"], promotion["windows"]);
  const json promoted = JsonOf("priors list" + At(other));
  EXPECT_TRUE(promoted["quarantined"].empty());
  ASSERT_EQ(promoted["scenes"].size(), 1u);
  EXPECT_EQ(promoted["scenes"][0]["arms"], posteriors[0]["arms"]) << "to the last bit";
  EXPECT_EQ(JsonOf("priors revoke --until 1 --yes" + At(other))["sources"], 2);
  EXPECT_TRUE(JsonOf("priors list" + At(other))["scenes"].empty());
}

}  // namespace
}  // namespace sweepstake::cli
