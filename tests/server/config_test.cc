// Tests the configuration: its sources, their precedence, and the errors about wrong values.
#include "server/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
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

using Words = std::vector<std::string>;

// A configuration whose settings are parsed from a command line.
struct Loaded {
  // Returns the error for these flags, or nothing.
  std::string Parse(Words words) {
    std::reverse(words.begin(), words.end());  // CLI11 expects the words in reverse order
    try {
      app.parse(words);
    } catch (const CLI::Error& error) {
      return error.what();
    }
    return "";
  }
  std::string ReadEnvironment(const Words& variables) {
    return std::string(settings.ReadEnvironment(variables).message());
  }

  CLI::App app;
  Config config;
  Settings settings{app, config};
};

class ConfigTest : public ::testing::Test {
 protected:
  ConfigTest()
      : path_(::testing::TempDir() + "sweepstake-config-" + std::to_string(getpid()) + ".toml") {}
  ~ConfigTest() override { std::filesystem::remove(path_); }

  absl::StatusOr<Config> FromFile(const std::string& text) {
    std::ofstream(path_) << text;
    Loaded loaded;
    absl::Status status = loaded.settings.ReadFile(path_);
    if (status.ok()) status = Validate(loaded.config);
    if (!status.ok()) return status;
    return loaded.config;
  }
  std::string Error(const std::string& text) {
    return std::string(FromFile(text).status().message());
  }

  std::filesystem::path path_;
};

TEST_F(ConfigTest, TheDefaultsAreValidAndEqualThePapers) {
  const Config config;
  EXPECT_TRUE(Validate(config).ok());
  EXPECT_EQ(config.rpc.decision.cooldown_ns, 40'000'000'000);
  EXPECT_EQ(config.rpc.max_time_scale, 1);
}

TEST_F(ConfigTest, AFileSetsTheNamedSettings) {
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
  std::ofstream(path_)
      << "max_scenes = 1\ninsecure = false\n[decision]\ncooldown_ms = 1\nsettling_ms = 1\n";
  Loaded loaded;
  const Words flags = {"--decision-cooldown-ms", "3", "--insecure"};
  EXPECT_EQ(loaded.Parse(flags), "");  // the program also parses the flags first, to find the file
  ASSERT_TRUE(loaded.settings.ReadFile(path_).ok());
  EXPECT_EQ(loaded.ReadEnvironment(
                {"SWEEPSTAKE_DECISION_COOLDOWN_MS=2", "SWEEPSTAKE_MAX_SCENES=2", "PATH=/bin"}),
            "");
  EXPECT_EQ(loaded.Parse(flags), "");
  EXPECT_TRUE(loaded.config.insecure);
  EXPECT_EQ(loaded.config.rpc.decision.cooldown_ns, 3'000'000);
  EXPECT_EQ(loaded.config.rpc.max_scenes, 2u);
  EXPECT_EQ(loaded.config.rpc.decision.settling_ns, 1'000'000);
}

TEST_F(ConfigTest, AnUnknownKeyIsAnErrorThatNamesTheNearest) {
  EXPECT_THAT(
      Error("[decision]\ncooldwn_ms = 1\n"),
      EndsWith("unknown setting 'decision.cooldwn_ms', the nearest is decision.cooldown_ms; "
               "--help lists all"));
  EXPECT_THAT(Error("lissten = 'x'\n"), HasSubstr("'lissten', the nearest is listen; "));
  EXPECT_THAT(Loaded().ReadEnvironment({"SWEEPSTAKE_LISTN=x"}),
              HasSubstr("environment: unknown setting 'SWEEPSTAKE_LISTN', the nearest is "
                        "SWEEPSTAKE_LISTEN; "));
}

TEST_F(ConfigTest, VariablesThatKubernetesSetsAreIgnored) {
  Loaded loaded;
  EXPECT_EQ(loaded.ReadEnvironment(
                {"SWEEPSTAKE_SERVICE_HOST=10.0.0.1", "SWEEPSTAKE_PORT_7433_TCP=tcp://10.0.0.1:7433",
                 "SWEEPSTAKE_HTTP_SERVICE_HOST=10.0.0.1", "SWEEPSTAKE_HTTP_SERVICE_PORT_WEB=80",
                 "SWEEPSTAKE_HTTP_PORT=tcp://10.0.0.1:80",
                 "SWEEPSTAKE_HTTP_PORT_80_TCP_ADDR=10.0.0.1", "SWEEPSTAKE_PORT_FILE=p"}),
            "");
  Config expected;
  expected.port_file = "p";
  EXPECT_EQ(PrintConfig(loaded.config), PrintConfig(expected));
  EXPECT_THAT(loaded.ReadEnvironment({"SWEEPSTAKE_PORT_FLE=p"}), HasSubstr("SWEEPSTAKE_PORT_FILE"));
}

TEST_F(ConfigTest, ASwitchOfTheCommandLineIsTrueOrFalse) {
  for (const char* value : {"maybe", "5", "-1", "yes", "99999999999999999999"}) {
    EXPECT_THAT(Loaded().Parse({std::string("--insecure=") + value}), HasSubstr("--insecure: "))
        << value;
  }
  EXPECT_THAT(Loaded().Parse({"--decision-explore=maybe"}), HasSubstr("--decision-explore"));
  EXPECT_THAT(Loaded().Parse({"--no-insecure=maybe"}), HasSubstr("--insecure: "));
  Loaded loaded;
  EXPECT_EQ(loaded.Parse({"--insecure", "--decision-explore=false", "--no-require-tokens"}), "");
  EXPECT_TRUE(loaded.config.insecure);
  EXPECT_FALSE(loaded.config.rpc.decision.explore);
  EXPECT_EQ(loaded.Parse({"--insecure", "--no-insecure"}), "");
  EXPECT_FALSE(loaded.config.insecure) << "the last one counts";
}

TEST_F(ConfigTest, NamedFilesAndDirectoriesMustExist) {
  const auto said = [this](const std::string& text) {
    return std::string(CheckFiles(FromFile(text).value()).message());
  };
  EXPECT_EQ(said(""), "");
  EXPECT_EQ(said("data = '" + ::testing::TempDir() + "not-yet'\n"), "");
  EXPECT_THAT(said("data = '/nonexistent/sweepstake/data'\n"),
              HasSubstr("data: /nonexistent/sweepstake is not a directory"));
  EXPECT_THAT(said("port_file = '/nonexistent/port'\n"), HasSubstr("port_file: /nonexistent is"));
  EXPECT_THAT(said("tls_cert = 'no.pem'\ntls_key = 'no-key.pem'\ntls_client_ca = 'no-ca.pem'\n"),
              AllOf(HasSubstr("cannot read no.pem"), HasSubstr("\ncannot read no-key.pem"),
                    HasSubstr("\ncannot read no-ca.pem")));
  std::ofstream(path_) << "";
  EXPECT_THAT(said("data = '" + path_.string() + "'\n"),
              HasSubstr("data: " + path_.string() + " is not a directory; name another"));
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
              HasSubstr("http: listen has the same address"));
  EXPECT_TRUE(FromFile("listen = '127.0.0.1:0'\nhttp = '127.0.0.1:0'\n").ok());
}

TEST_F(ConfigTest, AllProblemsOfAFileAreReportedAtOnceOnePerLine) {
  std::ofstream(path_)
      << "lissten = 'x'\nmax_scenes = 0\nhttp = '7434'\ntls_cert = 'c.pem'\n"
         "database_mb = 20\naudit_mb = 11\nport_file = '/nonexistent/port'\n"
         "[decision]\nweight_fps = 0.9\npolicy = 'x'\ninterval_ms = 0\nfps_floor = -1\n";
  const std::string said(CheckConfigFile(path_).message());
  for (const char* wrong :
       {"toml:1: unknown setting 'lissten'", "toml:2: max_scenes: ", "http: expected HOST:PORT",
        "tls_cert and tls_key go together", "at least twice audit_mb",
        "port_file: /nonexistent is not a directory", "cannot read c.pem",
        "decision: unknown policy", "decision: the reward weights sum to",
        "decision: decision_interval_ns is 0", "decision: fps_floor is negative"}) {
    EXPECT_THAT(said, HasSubstr(wrong));
  }
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 10) << said;
  for (const auto line : absl::StrSplit(said, '\n'))
    EXPECT_EQ(std::string(line).rfind(path_.string() + ":", 0), 0u) << line;
  std::ofstream(path_) << "listen = [1]\nhttp = [2]\n";
  EXPECT_THAT(std::string(CheckConfigFile(path_).message()),
              AllOf(HasSubstr("listen: expected a string"), HasSubstr("http: expected a string")));
  std::ofstream(path_) << "max_scenes = 7\n";
  EXPECT_TRUE(CheckConfigFile(path_).ok());
}

TEST_F(ConfigTest, AnErrorNamesTheSettingAsItsSourceDoes) {
  EXPECT_THAT(Error("\nmax_scenes = 0\n"), HasSubstr("toml:2: max_scenes: Value 0 not in range"));
  EXPECT_THAT(Loaded().ReadEnvironment({"SWEEPSTAKE_MAX_SCENES=0"}),
              HasSubstr("environment: SWEEPSTAKE_MAX_SCENES: Value 0 not in range"));
  EXPECT_THAT(Loaded().Parse({"--max-scenes=0"}), HasSubstr("--max-scenes: Value 0 not in range"));
}

TEST_F(ConfigTest, HelpShowsBoundsAndDefaults) {
  const std::string help = Loaded().app.help();
  EXPECT_THAT(help, HasSubstr("--max-sessions INT:INT in [1 - 1000000]=20000"));
  EXPECT_THAT(help, HasSubstr("[decision.cooldown_ms, SWEEPSTAKE_DECISION_COOLDOWN_MS]"));
}

TEST_F(ConfigTest, ADirectoryIsAnError) {
  EXPECT_THAT(std::string(Loaded().settings.ReadFile(::testing::TempDir()).message()),
              HasSubstr("is a directory, not a file"));
}

TEST_F(ConfigTest, TextThatIsNotUtf8IsAnError) {
  EXPECT_THAT(Loaded().ReadEnvironment({"SWEEPSTAKE_DATA=\xff"}), HasSubstr("expected UTF-8"));
}

TEST_F(ConfigTest, AWrongValueIsAnErrorThatNamesTheBounds) {
  EXPECT_THAT(Error("[decision]\ncooldown_ms = -1\n"), HasSubstr("not in range 0 to 31536000000"));
  EXPECT_THAT(Error("[decision]\ncooldown_ms = 1.5\n"), HasSubstr("Value 1.5 not in range"));
  EXPECT_THAT(Error("[decision]\nweight_fps = nan\n"), HasSubstr("expected a finite number"));
  EXPECT_THAT(Error("[decision]\nweight_fps = 0.9\n"), HasSubstr("sum to"));
  EXPECT_THAT(Error("[decision]\npolicy = 'dice'\n"), HasSubstr("paper"));
  EXPECT_THAT(Error("[decision]\nexplore = 1\n"), HasSubstr("not in {"));
  EXPECT_THAT(Error("data = \"a\\u0007b\"\n"), HasSubstr("expected UTF-8 without control"));
  EXPECT_THAT(Error("max_time_scale = 0\n"), HasSubstr("not in range 1 to 1000"));
  EXPECT_THAT(Error("max_time_scale = 1001\n"), HasSubstr("not in range 1 to 1000"));
  EXPECT_THAT(Error("log_level = 'loud'\n"), HasSubstr("trace,debug,info"));
  EXPECT_THAT(Error("listen = 'here'\n"), HasSubstr("expected HOST:PORT"));
  EXPECT_THAT(Error("listen = '127.0.0.1:70000'\n"), HasSubstr("expected HOST:PORT"));
  EXPECT_THAT(Error("listen = '::1:0'\n"), HasSubstr("expected [::1]:0, not ::1:0"));
  EXPECT_TRUE(FromFile("listen = '[::1]:0'\n").ok());
  EXPECT_THAT(Error("http = '7434'\n"), HasSubstr("http: expected HOST:PORT"));
  EXPECT_THAT(Error("listen = [1]\n"), HasSubstr("expected a string"));
  EXPECT_THAT(Error("max_sessions = 99999999999999999999\n"), HasSubstr(":1:"));
}

TEST_F(ConfigTest, ASyntaxErrorIsReportedWithItsLine) {
  EXPECT_THAT(Error("\n= 3\n"), HasSubstr(":2:"));
}

TEST_F(ConfigTest, AMissingFileIsAnError) {
  EXPECT_TRUE(absl::IsNotFound(Loaded().settings.ReadFile("/nonexistent.toml")));
}

TEST_F(ConfigTest, PlainTextOnOtherAddressesNeedsASwitch) {
  EXPECT_THAT(Error("listen = '0.0.0.0:7433'\n"), HasSubstr("--insecure"));
  EXPECT_THAT(Error("listen = '127.0.0.1.example.com:7433'\n"), HasSubstr("--insecure"));
  EXPECT_TRUE(FromFile("listen = '0.0.0.0:7433'\ninsecure = true\n").ok());
  EXPECT_TRUE(FromFile("listen = '[::1]:7433'\n").ok());
  EXPECT_THAT(Error("http = '0.0.0.0:7434'\n"),
              AllOf(HasSubstr("http: "), HasSubstr("--http-plain")));
  EXPECT_THAT(Error("http = '0.0.0.0:7434'\ninsecure = true\n"), HasSubstr("--http-plain"));
  const auto plain = FromFile("http = '0.0.0.0:7434'\nhttp_plain = true\n");
  ASSERT_TRUE(plain.ok()) << plain.status();
  EXPECT_TRUE(NeedsToken(*plain)) << "plain HTTP does not admit everyone";
}

TEST_F(ConfigTest, HttpUsesTlsWhereOtherMachinesReachIt) {
  const std::string tls = "tls_cert = 'c'\ntls_key = 'k'\ntls_client_ca = 'a'\n";
  const tls::Files files = HttpTls(*FromFile(tls + "http = '0.0.0.0:7434'\n"));
  EXPECT_EQ(files.cert, "c");
  EXPECT_EQ(files.key, "k");
  EXPECT_EQ(files.ca, "") << "browsers have no certificates";
  EXPECT_EQ(HttpTls(*FromFile(tls + "http = '127.0.0.1:7434'\n")).cert, "");
  EXPECT_EQ(HttpTls(*FromFile(tls + "http = '0.0.0.0:7434'\nhttp_plain = true\n")).cert, "");
}

TEST_F(ConfigTest, TheBaseOfHttpIsAPath) {
  const auto config = FromFile("http_base = '/tools/sweep-stake_1'\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->http_base, "/tools/sweep-stake_1");
  EXPECT_TRUE(FromFile("http_base = ''\n").ok());
  for (const char* wrong : {"/", "sweepstake", "/sweepstake/", "//a", "/a/../b", "/a b", "/\"><b>",
                            "https://dash/a", "/a?b"}) {
    EXPECT_THAT(Error(std::string("http_base = '") + wrong + "'\n"),
                HasSubstr("expected a path such as /sweepstake"))
        << wrong;
  }
  EXPECT_THAT(Error("http_base = '/livez'\n"), HasSubstr("/livez is a path of the daemon"));
  EXPECT_THAT(Error("http_base = '/api/x'\n"), HasSubstr("/api is a path of the daemon"));
}

TEST_F(ConfigTest, TheWebhookIsAnHttpUrl) {
  for (const char* right : {"", "https://example.org/alerts?key=1", "http://127.0.0.1:8080"}) {
    const auto config = FromFile(std::string("webhook = '") + right + "'\n");
    ASSERT_TRUE(config.ok()) << config.status();
    EXPECT_EQ(config->webhook, right);
  }
  for (const char* wrong : {"example.org", "ftp://example.org", "https://", "https:///a",
                            "https://example.org/a b", "file:///etc/passwd"}) {
    EXPECT_THAT(Error(std::string("webhook = '") + wrong + "'\n"), HasSubstr("expected a URL"))
        << wrong;
  }
}

TEST_F(ConfigTest, TheNumberOfScenesWithMetricsIsBounded) {
  EXPECT_EQ(FromFile("metrics_scenes = 1000\n")->rpc.alerts.max_metric_scenes, 1'000u);
  EXPECT_THAT(Error("metrics_scenes = 1001\n"), HasSubstr("1000"));
}

TEST_F(ConfigTest, HttpHostsAreTheHostOfHttpAndTheListedNames) {
  const auto config = FromFile(
      "http_plain = true\nhttp = 'Build-Server:7434'\nhttp_hosts = ' dash.example.com,B_1 ,, "
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

TEST_F(ConfigTest, TokensMayBeRequiredOnEveryAddress) {
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

TEST_F(ConfigTest, WithTlsOtherMachinesMayConnect) {
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

TEST_F(ConfigTest, VariablesOfTheCommandLineAreIgnored) {
  EXPECT_EQ(Loaded().ReadEnvironment({"SWEEPSTAKE_CLIENT_TLS_CA=a.pem"}), "");
}

TEST_F(ConfigTest, TheDatabaseMustHaveRoomForItsAuditLog) {
  EXPECT_TRUE(FromFile("database_mb = 20\naudit_mb = 10\n").ok());
  EXPECT_THAT(Error("database_mb = 20\naudit_mb = 11\n"), HasSubstr("at least twice audit_mb"));
}

TEST_F(ConfigTest, APrintedConfigurationReadsBackTheSame) {
  Config config;
  config.data = "a \"quoted\" \\ # path";
  config.rpc.decision.weights = {.fps = 0.1, .detection = 0.2, .memory = 0.3, .checks = 0.4};
  const auto read = FromFile(PrintConfig(config));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(PrintConfig(*read), PrintConfig(config));
}

}  // namespace
}  // namespace sweepstake::server
