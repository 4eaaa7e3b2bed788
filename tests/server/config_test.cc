// The configuration: where values come from, which one wins, and what is said about wrong ones.
#include "server/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "absl/strings/str_split.h"

namespace sweepstake::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ConfigTest : public ::testing::Test {
 protected:
  ConfigTest()
      : path_(::testing::TempDir() + "sweepstake-config-" + std::to_string(getpid()) + ".toml") {}
  ~ConfigTest() override { std::filesystem::remove(path_); }

  absl::StatusOr<Config> FromFile(const std::string& text) {
    std::ofstream(path_) << text;
    auto assignments = ReadConfigFile(path_);
    if (!assignments.ok()) return assignments.status();
    Config config;
    absl::Status status = Assign(*assignments, "file", config);
    if (status.ok()) status = Validate(config);
    if (!status.ok()) return status;
    return config;
  }
  std::string Error(const std::string& text) {
    return std::string(FromFile(text).status().message());
  }

  std::filesystem::path path_;
};

TEST_F(ConfigTest, TheDefaultsAreValidAndThePapers) {
  const Config config;
  EXPECT_TRUE(Validate(config).ok());
  EXPECT_EQ(config.rpc.decision.cooldown_ns, 40'000'000'000);
  EXPECT_EQ(config.rpc.max_time_scale, 1);
}

TEST_F(ConfigTest, AFileSetsWhatItNames) {
  const auto config = FromFile(
      "listen = '127.0.0.1:0'\ndatabase_mb = 9\naudit_mb = 2\naudit_days = "
      "3\n[decision]\ncooldown_ms = "
      "1500\nexplore = false\n"
      "weight_fps = 1\nweight_detection = 0.0\nweight_memory = 0\nweight_checks = 0\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->listen, "127.0.0.1:0");
  EXPECT_EQ(config->database_bytes, 9u << 20);
  EXPECT_EQ(config->audit.bytes, 2u << 20);
  EXPECT_EQ(config->audit.age_s, 3u * 86'400);
  EXPECT_EQ(config->rpc.decision.cooldown_ns, 1'500'000'000);
  EXPECT_FALSE(config->rpc.decision.explore);
  EXPECT_EQ(config->rpc.decision.weights.fps, 1);
}

TEST_F(ConfigTest, TheLaterSourceWins) {
  Config config;
  ASSERT_TRUE(
      Assign({{"decision.cooldown_ms", "1"}, {"decision.settling_ms", "1"}}, "file", config).ok());
  const std::vector<std::string> environment = {"SWEEPSTAKE_DECISION_COOLDOWN_MS=2", "PATH=/bin"};
  ASSERT_TRUE(Assign(*ReadEnvironment(environment), "environment", config).ok());
  EXPECT_EQ(config.rpc.decision.cooldown_ns, 2'000'000);
  EXPECT_EQ(config.rpc.decision.settling_ns, 1'000'000);
}

TEST_F(ConfigTest, AnUnknownKeyIsAnErrorThatSaysWhichIsNearest) {
  EXPECT_THAT(
      Error("[decision]\ncooldwn_ms = 1\n"),
      EndsWith("unknown setting 'decision.cooldwn_ms', the nearest is decision.cooldown_ms; "
               "--help lists all"));
  EXPECT_THAT(Error("lissten = 'x'\n"), HasSubstr("'lissten', the nearest is listen; "));
  const std::vector<std::string> environment = {"SWEEPSTAKE_LISTN=x"};
  EXPECT_THAT(std::string(ReadEnvironment(environment).status().message()),
              HasSubstr("unknown environment variable 'SWEEPSTAKE_LISTN', the nearest is "
                        "SWEEPSTAKE_LISTEN; "));
}

TEST_F(ConfigTest, VariablesThatKubernetesMakesAreNotTakenForOurs) {
  const std::vector<std::string> environment = {"SWEEPSTAKE_SERVICE_HOST=10.0.0.1",
                                                "SWEEPSTAKE_PORT_7433_TCP=tcp://10.0.0.1:7433",
                                                "SWEEPSTAKE_HTTP_SERVICE_HOST=10.0.0.1",
                                                "SWEEPSTAKE_HTTP_SERVICE_PORT_WEB=80",
                                                "SWEEPSTAKE_HTTP_PORT=tcp://10.0.0.1:80",
                                                "SWEEPSTAKE_HTTP_PORT_80_TCP_ADDR=10.0.0.1",
                                                "SWEEPSTAKE_PORT_FILE=p"};
  const auto assignments = ReadEnvironment(environment);
  ASSERT_TRUE(assignments.ok()) << assignments.status();
  EXPECT_EQ(*assignments, (Assignments{{"port_file", "p"}}));
  const std::vector<std::string> misspelt = {"SWEEPSTAKE_PORT_FLE=p"};
  EXPECT_THAT(std::string(ReadEnvironment(misspelt).status().message()),
              HasSubstr("SWEEPSTAKE_PORT_FILE"));
}

TEST_F(ConfigTest, ASwitchOfTheCommandLineIsTrueOrFalse) {
  const auto said = [](const std::vector<std::string>& words) {
    return std::string(CheckSwitches(words).message());
  };
  for (const char* value : {"maybe", "", "5", "-1", "yes", "99999999999999999999"}) {
    EXPECT_THAT(said({"--listen", "x", std::string("--insecure=") + value}),
                HasSubstr("--insecure: expected true or false"))
        << value;
  }
  EXPECT_THAT(said({"--decision-explore=maybe"}), HasSubstr("--decision-explore"));
  EXPECT_THAT(said({"--no-insecure=maybe"}), HasSubstr("--no-insecure takes no value"));
  EXPECT_THAT(said({"--insecure", "--no-insecure"}), HasSubstr("both set and cleared"));
  EXPECT_THAT(said({"--insecure", "--insecure=false"}), HasSubstr("both set and cleared"));
  EXPECT_EQ(said({"--insecure", "--decision-explore=false", "--no-require-tokens"}), "");
  EXPECT_EQ(said({"--insecure=true", "--insecure"}), "");
}

TEST_F(ConfigTest, WhatItNamesOnTheMachineMustBeThere) {
  const auto said = [this](const std::string& text) {
    return std::string(CheckFiles(FromFile(text).value()).message());
  };
  EXPECT_EQ(said(""), "");
  EXPECT_EQ(said("data = '" + ::testing::TempDir() + "not-yet'\n"), "");
  EXPECT_THAT(said("data = '/nonexistent/sweepstake/data'\n"),
              HasSubstr("data: /nonexistent/sweepstake is no directory"));
  EXPECT_THAT(said("port_file = '/nonexistent/port'\n"), HasSubstr("port_file: /nonexistent is"));
  EXPECT_THAT(said("tls_cert = 'no.pem'\ntls_key = 'no-key.pem'\ntls_client_ca = 'no-ca.pem'\n"),
              AllOf(HasSubstr("cannot read no.pem"), HasSubstr("\ncannot read no-key.pem"),
                    HasSubstr("\ncannot read no-ca.pem")));
  std::ofstream(path_) << "";
  EXPECT_THAT(said("data = '" + path_.string() + "'\n"),
              HasSubstr("data: " + path_.string() + " is no directory; name another"));
  EXPECT_THAT(said("port_file = '" + ::testing::TempDir() + "'\n"),
              HasSubstr("port_file: " + ::testing::TempDir() + " is a directory; name a file"));
}

TEST_F(ConfigTest, ASharedStoreIsAUrlWithoutAPassword) {
  const auto config = FromFile("store = 'postgresql://sweepstake@db.example:5432/priors'\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->store, "postgresql://sweepstake@db.example:5432/priors");
  EXPECT_TRUE(FromFile("store = 'postgres:///priors?host=/run/postgresql'\n").ok());
  for (const char* wrong : {"db.example", "mysql://db.example/priors"}) {
    EXPECT_THAT(Error(std::string("store = '") + wrong + "'\n"),
                HasSubstr("store: expected a URL such as"));
  }
  for (const char* telltale :
       {"postgresql://me:secret@db/priors", "postgresql:///priors?password=secret"}) {
    const std::string said = Error(std::string("store = '") + telltale + "'\n");
    EXPECT_THAT(said, HasSubstr("name that in PGPASSFILE"));
    EXPECT_THAT(said, Not(HasSubstr("secret")));
  }
}

TEST_F(ConfigTest, TwoListenersNeedTwoAddresses) {
  EXPECT_THAT(Error("listen = '127.0.0.1:7433'\nhttp = '127.0.0.1:7433'\n"),
              HasSubstr("http: 127.0.0.1:7433 is that of listen, too"));
  EXPECT_TRUE(FromFile("listen = '127.0.0.1:0'\nhttp = '127.0.0.1:0'\n").ok());
}

TEST_F(ConfigTest, AllThatIsWrongInAFileIsSaidAtOnceALineForEach) {
  std::ofstream(path_)
      << "lissten = 'x'\nmax_scenes = 0\nhttp = '7434'\ntls_cert = 'c.pem'\n"
         "database_mb = 20\naudit_mb = 11\nport_file = '/nonexistent/port'\n"
         "[decision]\nweight_fps = 0.9\npolicy = 'x'\ninterval_ms = 0\nfps_floor = -1\n";
  const std::string said(CheckConfigFile(path_).message());
  for (const char* wrong :
       {"unknown setting 'lissten'", "max_scenes: expected", "http: expected HOST:PORT",
        "tls_cert and tls_key go together", "at least twice audit_mb",
        "port_file: /nonexistent is no directory", "cannot read c.pem", "decision: unknown policy",
        "decision: the reward weights sum to", "decision: decision_interval_ns is 0",
        "decision: fps_floor is negative"}) {
    EXPECT_THAT(said, HasSubstr(wrong));
  }
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 10) << said;
  for (const auto line : absl::StrSplit(said, '\n'))
    EXPECT_EQ(std::string(line).rfind(path_.string() + ": ", 0), 0u) << line;
  std::ofstream(path_) << "listen = [1]\nhttp = [2]\n";
  EXPECT_THAT(std::string(CheckConfigFile(path_).message()),
              AllOf(HasSubstr("listen: expected a text"), HasSubstr("http: expected a text")));
  std::ofstream(path_) << "max_scenes = 7\n";
  EXPECT_TRUE(CheckConfigFile(path_).ok());
}

TEST_F(ConfigTest, AMessageCallsASettingWhatItsSourceCallsIt) {
  const Assignments cert = {{"tls_cert", "c.pem"}};
  const auto said = [&](auto add) {
    SettingNames names;
    (names.*add)(cert);
    Config config;
    EXPECT_TRUE(Assign(cert, "somewhere", config, names).ok());
    return std::string(Validate(config, names).message());
  };
  EXPECT_THAT(said(&SettingNames::AddKeys), HasSubstr("tls_cert and tls_key go together"));
  EXPECT_THAT(said(&SettingNames::AddFlags), HasSubstr("--tls-cert and --tls-key go together"));
  EXPECT_THAT(said(&SettingNames::AddVariables),
              HasSubstr("SWEEPSTAKE_TLS_CERT and tls_key go together"));
  SettingNames names;
  names.AddFlags({{"max_scenes", "0"}});
  Config config;
  EXPECT_THAT(std::string(Assign({{"max_scenes", "0"}}, "command line", config, names).message()),
              HasSubstr("command line: --max-scenes: expected"));
}

TEST_F(ConfigTest, ADirectoryIsNoFile) {
  const auto assignments = ReadConfigFile(::testing::TempDir());
  EXPECT_THAT(std::string(assignments.status().message()), HasSubstr("is a directory, not a file"));
}

TEST_F(ConfigTest, TextThatNoFileCouldHaveIsAnError) {
  Config config;
  const absl::Status status = Assign({{"data", "\xff"}}, "environment", config);
  EXPECT_THAT(std::string(status.message()), HasSubstr("expected UTF-8"));
}

TEST_F(ConfigTest, AWrongValueIsAnErrorThatSaysWhatWouldBeRight) {
  EXPECT_THAT(Error("[decision]\ncooldown_ms = -1\n"), HasSubstr("expected a whole number from 0"));
  EXPECT_THAT(Error("[decision]\ncooldown_ms = 1.5\n"),
              HasSubstr("expected a whole number from 0"));
  EXPECT_THAT(Error("[decision]\nweight_fps = nan\n"), HasSubstr("expected a finite number"));
  EXPECT_THAT(Error("[decision]\nweight_fps = 0.9\n"), HasSubstr("sum to"));
  EXPECT_THAT(Error("[decision]\npolicy = 'dice'\n"), HasSubstr("paper"));
  EXPECT_THAT(Error("[decision]\nexplore = 1\n"), HasSubstr("expected true or false"));
  EXPECT_THAT(Error("data = \"a\\u0007b\"\n"), HasSubstr("expected UTF-8 without control"));
  EXPECT_THAT(Error("max_time_scale = 0\n"), HasSubstr("expected a whole number from 1 to 1000"));
  EXPECT_THAT(Error("max_time_scale = 1001\n"), HasSubstr("from 1 to 1000"));
  EXPECT_THAT(Error("log_level = 'loud'\n"), HasSubstr("trace, debug, info"));
  EXPECT_THAT(Error("listen = 'here'\n"), HasSubstr("expected HOST:PORT"));
  EXPECT_THAT(Error("listen = '127.0.0.1:70000'\n"), HasSubstr("expected HOST:PORT"));
  EXPECT_THAT(Error("listen = '::1:0'\n"), HasSubstr("expected [::1]:0, not ::1:0"));
  EXPECT_TRUE(FromFile("listen = '[::1]:0'\n").ok());
  EXPECT_THAT(Error("http = '7434'\n"), HasSubstr("http: expected HOST:PORT"));
  EXPECT_THAT(Error("listen = [1]\n"), HasSubstr("expected a text"));
  EXPECT_THAT(Error("max_sessions = 99999999999999999999\n"), HasSubstr(":1:"));
}

TEST_F(ConfigTest, AFileThatIsNoTomlIsAnErrorWithItsLine) {
  EXPECT_THAT(Error("\n= 3\n"), HasSubstr(":2:"));
}

TEST_F(ConfigTest, AMissingFileIsAnError) {
  EXPECT_TRUE(absl::IsNotFound(ReadConfigFile("/nonexistent.toml").status()));
}

TEST_F(ConfigTest, PlainTextOffLoopbackMustBeAskedFor) {
  EXPECT_THAT(Error("listen = '0.0.0.0:7433'\n"), HasSubstr("--insecure"));
  EXPECT_THAT(Error("listen = '127.0.0.1.example.com:7433'\n"), HasSubstr("--insecure"));
  EXPECT_TRUE(FromFile("listen = '0.0.0.0:7433'\ninsecure = true\n").ok());
  EXPECT_TRUE(FromFile("listen = '[::1]:7433'\n").ok());
  EXPECT_THAT(Error("http = '0.0.0.0:7434'\n"),
              AllOf(HasSubstr("http: "), HasSubstr("--insecure")));
  EXPECT_TRUE(FromFile("http = '0.0.0.0:7434'\ninsecure = true\n").ok());
}

TEST_F(ConfigTest, HttpHasTheNamesOfItsAddressAndThoseThatAreListed) {
  const auto config = FromFile(
      "insecure = true\nhttp = 'Build-Server:7434'\nhttp_hosts = ' dash.example.com,B_1 ,, "
      "[2001:db8::1]'\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_THAT(HttpHosts(*config),
              ::testing::ElementsAre("[2001:db8::1]", "b_1", "build-server", "dash.example.com"));
  EXPECT_TRUE(HttpHosts({}).empty());
  for (const char* wrong : {"https://dash", "dash:80", "a b", "*", "2001:db8::1", "a/"}) {
    EXPECT_THAT(Error(std::string("http_hosts = '") + wrong + "'\n"),
                AllOf(HasSubstr("http_hosts: expected names"), HasSubstr(wrong)));
  }
}

TEST_F(ConfigTest, TokensMayBeRequiredWhereverItListens) {
  EXPECT_FALSE(NeedsToken(FromFile("").value()));
  EXPECT_TRUE(NeedsToken(FromFile("require_tokens = true\n").value()));
  EXPECT_TRUE(NeedsToken(FromFile("require_tokens = true\ninsecure = true\n").value()));
}

TEST_F(ConfigTest, ChangedSettingsAreNamed) {
  const Config before;
  Config after;
  EXPECT_THAT(ChangedSettings(before, after).live, IsEmpty());
  EXPECT_THAT(ChangedSettings(before, after).fixed, IsEmpty());
  after.log_level = "debug";
  after.rpc.decision.cooldown_ns = 1'000'000;
  after.rpc.max_scenes = 7;
  EXPECT_THAT(ChangedSettings(before, after).live, ElementsAre("log_level", "max_scenes"));
  EXPECT_THAT(ChangedSettings(before, after).fixed, ElementsAre("decision.cooldown_ms"));
}

TEST_F(ConfigTest, WithTlsOthersMayReachIt) {
  const std::string pair = "tls_cert = 'c.pem'\ntls_key = 'k.pem'\n";
  const auto config = FromFile("listen = '0.0.0.0:7433'\ntls_client_ca = 'a.pem'\n" + pair);
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->rpc.tls.cert, "c.pem");
  EXPECT_EQ(config->rpc.tls.key, "k.pem");
  EXPECT_EQ(config->rpc.tls.ca, "a.pem");
  EXPECT_THAT(Error("tls_cert = 'c.pem'\n"), HasSubstr("tls_cert and tls_key go together"));
  EXPECT_THAT(Error("tls_key = 'k.pem'\n"), HasSubstr("tls_cert and tls_key go together"));
  EXPECT_THAT(Error("tls_client_ca = 'a.pem'\n"), HasSubstr("tls_client_ca needs TLS"));
  EXPECT_THAT(Error("listen = '0.0.0.0:7433'\n"), HasSubstr("--tls-cert"));
}

TEST_F(ConfigTest, TheCommandLinesVariablesAreNotTakenForOurs) {
  const std::vector<std::string> environment = {"SWEEPSTAKE_CLIENT_TLS_CA=a.pem"};
  const auto assignments = ReadEnvironment(environment);
  ASSERT_TRUE(assignments.ok()) << assignments.status();
  EXPECT_TRUE(assignments->empty());
}

TEST_F(ConfigTest, TheDatabaseMustHaveRoomForItsAuditLog) {
  EXPECT_TRUE(FromFile("database_mb = 20\naudit_mb = 10\n").ok());
  EXPECT_THAT(Error("database_mb = 20\naudit_mb = 11\n"), HasSubstr("at least twice audit_mb"));
}

TEST_F(ConfigTest, WhatIsPrintedReadsBackTheSame) {
  Config config;
  config.data = "a \"quoted\" \\ path";
  config.rpc.decision.weights = {.fps = 0.1, .detection = 0.2, .memory = 0.3, .checks = 0.4};
  const auto read = FromFile(PrintConfig(config));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(PrintConfig(*read), PrintConfig(config));
}

}  // namespace
}  // namespace sweepstake::server
