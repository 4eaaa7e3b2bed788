#include "engine_client/cli/command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

struct Numbers {
  uint64_t whole = 7;
  double real = 0.5;
  uint64_t seed = 1;
  std::string daemon = "none";
  bool json = false;
};

// Returns the exit code of the command `numbers` with these arguments, or 100 + the exit code of a
// parse error.
int Parse(const std::string& arguments, Numbers& parsed) {
  CLI::App app("test", "test");
  Terminal terminal{.out = std::cout, .err = std::cerr};
  int exit_code = -1;
  AddCommand<Numbers>(
      {app, terminal, exit_code, arguments}, "numbers", "Reads numbers",
      "  test numbers --whole 1\n",
      [](CLI::App& command, Numbers& numbers) {
        command.add_option("--whole", numbers.whole)->check(WholeUpTo(10));
        command.add_option("--real", numbers.real)->check(RealFrom(0, 1));
        AddSeedOption(command, numbers.seed, "the test");
        AddJsonFlag(command, numbers.json);
      },
      [&](const Numbers& numbers, Terminal&) {
        parsed = numbers;
        return 42;
      });
  try {
    app.parse("numbers " + arguments);
  } catch (const CLI::ParseError& error) {
    return 100 + error.get_exit_code();
  }
  return exit_code;
}

TEST(AddCommand, RunsWithTheOptionsAndKeepsTheExitCode) {
  Numbers parsed;
  EXPECT_EQ(Parse("--whole 3 --real 0.25 --seed 9 --json", parsed), 42);
  EXPECT_EQ(parsed.whole, 3U);
  EXPECT_EQ(parsed.real, 0.25);
  EXPECT_EQ(parsed.seed, 9U);
  EXPECT_TRUE(parsed.json);
}

TEST(AddCommand, KeepsTheDefaultsOfOptionsThatAreNotGiven) {
  Numbers parsed{.whole = 0, .real = 0, .seed = 0, .daemon = "", .json = true};
  EXPECT_EQ(Parse("", parsed), 42);
  EXPECT_EQ(parsed.whole, 7U);
  EXPECT_EQ(parsed.real, 0.5);
  EXPECT_EQ(parsed.seed, 1U);
  EXPECT_FALSE(parsed.json);
}

TEST(AddCommand, EndsItsHelpWithTheExamples) {
  CLI::App app("test", "test");
  Terminal terminal{.out = std::cout, .err = std::cerr};
  int exit_code = 0;
  const std::string line;
  CLI::App* command = AddCommand<Numbers>(
      {app, terminal, exit_code, line}, "numbers", "Reads numbers", "  test numbers\n",
      [](CLI::App&, Numbers&) {}, [](const Numbers&, Terminal&) { return 0; });
  EXPECT_THAT(command->help(), HasSubstr("Examples:\n  test numbers\n"));
}

TEST(WholeUpTo, AcceptsItsRangeAndRejectsNumbersThatWouldWrapAround) {
  Numbers parsed;
  for (const char* valid : {"0", "10"}) {
    EXPECT_EQ(Parse(std::string("--whole ") + valid, parsed), 42) << valid;
  }
  for (const char* invalid : {"11", "-1", "18446744073709551615", "1.5", "ten"}) {
    EXPECT_GT(Parse(std::string("--whole=") + invalid, parsed), 100) << invalid;
  }
}

TEST(RealFrom, AcceptsItsRangeAndRejectsNan) {
  Numbers parsed;
  for (const char* valid : {"0", "1", "0.5", "1e-3"}) {
    EXPECT_EQ(Parse(std::string("--real ") + valid, parsed), 42) << valid;
  }
  for (const char* invalid : {"nan", "NaN", "inf", "-0.1", "1.01", "x"}) {
    EXPECT_GT(Parse(std::string("--real=") + invalid, parsed), 100) << invalid;
  }
}

TEST(NotNegative, AcceptsTheLargestNumberAndRefusesASign) {
  Numbers parsed;
  EXPECT_EQ(Parse("--seed 18446744073709551615", parsed), 42);
  EXPECT_EQ(parsed.seed, UINT64_MAX);
  EXPECT_GT(Parse("--seed=-1", parsed), 100);
  EXPECT_GT(Parse("--seed=-0", parsed), 100);
}

TEST(OneOf, NamesTheNearestWordFirst) {
  constexpr std::array<std::string_view, 3> kWords = {"auto", "on", "off"};
  CLI::App app("test", "test");
  std::string word;
  app.add_option("--shadow", word)->check(OneOf(kWords));
  EXPECT_NO_THROW(app.parse("--shadow on"));
  try {
    app.parse("--shadow offf");
    ADD_FAILURE() << "accepted";
  } catch (const CLI::ValidationError& error) {
    EXPECT_STREQ(error.what(), "--shadow: unknown value 'offf', must be one of off, auto, on");
  }
  EXPECT_THAT(app.help(), HasSubstr("{auto,on,off}"));
}

TEST(AddDaemonOptions, RequiresAnAddress) {
  CLI::App app("test", "test");
  DaemonOptions daemon;
  AddDaemonOptions(app, daemon);
  EXPECT_THROW(app.parse(""), CLI::RequiredError);
  EXPECT_NO_THROW(app.parse("--daemon 127.0.0.1:7433"));
  EXPECT_EQ(daemon.address, "127.0.0.1:7433");
  EXPECT_FALSE(daemon.tls.has_value());
}

TEST(AddDaemonOptions, EachTlsOptionImpliesTls) {
  const struct {
    const char* arguments;
    TlsOptions tls;
  } cases[] = {
      {"--tls", {"", "", "", ""}},
      {"--tls-ca a.pem", {"a.pem", "", "", ""}},
      {"--tls --tls-cert c.pem --tls-key k.pem", {"", "c.pem", "k.pem", ""}},
      {"--tls-server-name host", {"", "", "", "host"}},
  };
  for (const auto& [arguments, tls] : cases) {
    CLI::App app("test", "test");
    DaemonOptions daemon;
    AddDaemonOptions(app, daemon);
    app.parse(std::string("--daemon 127.0.0.1:7433 ") + arguments);
    ASSERT_TRUE(daemon.tls.has_value()) << arguments;
    EXPECT_EQ(daemon.tls->ca_file, tls.ca_file);
    EXPECT_EQ(daemon.tls->cert_file, tls.cert_file);
    EXPECT_EQ(daemon.tls->key_file, tls.key_file);
    EXPECT_EQ(daemon.tls->server_name, tls.server_name);
  }
}

std::string LineOf(std::vector<std::string> words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  return CommandLine(pointers);
}

TEST(CommandLine, QuotesWordsThatAShellWouldChange) {
  EXPECT_EQ(LineOf({"./sweepstake", "--scene=a,b", "", "my file", "it's", "$HOME"}),
            "./sweepstake --scene=a,b '' 'my file' 'it'\\''s' '$HOME'");
  EXPECT_EQ(LineOf({}), "");
}

TEST(CommandLine, QuotesEverySpecialCharacterOfAShell) {
  for (const char character : std::string("\n\t \"#&'()*;<>?[\\]`{|}~!^$")) {
    const std::string line = LineOf({std::string("a") + character});
    EXPECT_THAT(line, HasSubstr("'a")) << character;
  }
}

}  // namespace
}  // namespace sweepstake::cli
