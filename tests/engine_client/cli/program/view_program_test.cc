// Tests `sweepstake run --view` in a pseudo terminal, as a user at a terminal sees it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <utility>

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr char kCtrlC = 3;
constexpr char kCtrlZ = 26;
constexpr char kEnter[] = "\x1b[?1049h\x1b[?25l";
constexpr char kLeave[] = "\x1b[?25h\x1b[?1049l";

// `sweepstake` with a pseudo terminal as its standard streams.
class ProgramInTerminal {
 public:
  // `arguments` is a line for the shell. `no_color` becomes the variable NO_COLOR. With
  // `job_control`, the shell continues the program after Ctrl-Z.
  ProgramInTerminal(const std::string& arguments, winsize size, const std::string& no_color = "",
                    bool job_control = false) {
    const std::string line = "export NO_COLOR=" + no_color +
                             (job_control ? "; set -m; " : "; exec ") + SWEEPSTAKE_PROGRAM + " " +
                             arguments + (job_control ? "; echo suspended; fg; exit $?" : "");
    pid_ = forkpty(&terminal_, nullptr, nullptr, &size);
    if (pid_ != 0) return;
    execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    _exit(127);
  }
  ~ProgramInTerminal() {
    close(terminal_);
    if (pid_ > 0) kill(pid_, SIGKILL);
    if (pid_ > 0) waitpid(pid_, nullptr, 0);
  }
  ProgramInTerminal(const ProgramInTerminal&) = delete;
  ProgramInTerminal& operator=(const ProgramInTerminal&) = delete;

  // Reads until the output after `from` contains `text`. Returns where that is, or npos if the
  // program ended before. A run ends after a minute.
  size_t ReadUntil(const std::string& text, size_t from = 0) {
    size_t at = std::string::npos;
    while ((at = output_.find(text, from)) == std::string::npos && ReadSome()) {
    }
    return at;
  }
  void Resize(winsize size) const { ioctl(terminal_, TIOCSWINSZ, &size); }
  void Type(char key) const { ASSERT_EQ(write(terminal_, &key, 1), 1); }
  // Reads the rest; returns the exit code, or -1 if there is none.
  int Await() {
    while (ReadSome()) {
    }
    int status = 0;
    if (waitpid(pid_, &status, 0) != pid_) return -1;
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  const std::string& output() const { return output_; }

 private:
  bool ReadSome() {
    constexpr int kMinuteMs = 60'000;
    pollfd ready = {.fd = terminal_, .events = POLLIN, .revents = 0};
    char bytes[4096];
    if (poll(&ready, 1, kMinuteMs) <= 0) return false;
    const ssize_t count = read(terminal_, bytes, sizeof bytes);  // fails after the program's end
    if (count > 0) output_.append(bytes, static_cast<size_t>(count));
    return count > 0;
  }

  int terminal_ = -1;
  pid_t pid_ = -1;
  std::string output_;
};

constexpr winsize kUsualSize = {.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
constexpr char kManualGame[] =
    "run --scene suite-b --objects 60 --mode manual --arm SAP --embedded ";

TEST(ViewProgram, DrawsTheSceneUntilCtrlCAndRestoresTheTerminal) {
  ProgramInTerminal program(kManualGame + std::string("--view"), kUsualSize);
  const size_t first = program.ReadUntil("\x1b[H");
  ASSERT_NE(program.ReadUntil("\x1b[H", first + 1), std::string::npos) << program.output();
  EXPECT_THAT(program.output(), testing::StartsWith(kEnter));
  EXPECT_THAT(program.output(), HasSubstr("\x1b[38;5;178mSAP  ")) << "the active arm's colour";
  EXPECT_THAT(program.output(), HasSubstr("▶ SAP"));
  EXPECT_THAT(program.output(), HasSubstr("Mode manual: SAP stays active"));
  EXPECT_THAT(program.output(), HasSubstr("⡇")) << "an edge of the world";
  program.Type(kCtrlC);
  EXPECT_EQ(program.Await(), 0);
  const std::string& output = program.output();
  const size_t end = output.find(kLeave);
  ASSERT_NE(end, std::string::npos);
  EXPECT_THAT(output.substr(0, end), Not(HasSubstr("no priors yet")));
  const std::string after = output.substr(end + sizeof kLeave - 1);
  EXPECT_THAT(after, Not(HasSubstr("\x1b")));
  EXPECT_THAT(after, HasSubstr("no priors yet\r\n"));
  EXPECT_THAT(after, HasSubstr("Posteriors learnt in suite-b with 60 objects"));
}

TEST(ViewProgram, RestoresTheTerminalWhileCtrlZSuspendsIt) {
  ProgramInTerminal program(kManualGame + std::string("--view"), kUsualSize, "",
                            /*job_control=*/true);
  ASSERT_NE(program.ReadUntil("\x1b[H"), std::string::npos) << program.output();
  program.Type(kCtrlZ);
  const size_t suspended = program.ReadUntil("suspended\r\n");
  ASSERT_NE(suspended, std::string::npos) << program.output();
  EXPECT_THAT(program.output().substr(0, suspended), testing::EndsWith(kLeave));
  const size_t continued = program.ReadUntil(kEnter + std::string("\x1b[H"), suspended);
  ASSERT_NE(continued, std::string::npos) << program.output();
  EXPECT_THAT(program.output().substr(suspended, continued - suspended), Not(HasSubstr("\x1b")));
  program.Type(kCtrlC);
  EXPECT_EQ(program.Await(), 0);
}

TEST(ViewProgram, FollowsTheSizeOfTheTerminal) {
  ProgramInTerminal program("run --scene suite-b --objects 60 --embedded --view", kUsualSize);
  ASSERT_NE(program.ReadUntil("P(best)"), std::string::npos) << program.output();
  program.Resize({.ws_row = 5, .ws_col = 20, .ws_xpixel = 0, .ws_ypixel = 0});
  // The title is cut to 19 columns.
  ASSERT_NE(program.ReadUntil("\x1b[Hsuite-b, 60 objects\x1b[K"), std::string::npos);
  program.Type(kCtrlC);
  EXPECT_EQ(program.Await(), 0);
}

TEST(ViewProgram, NamesTheLatestSwitch) {
  ProgramInTerminal program(
      "run --scene suite-b --objects 60 --embedded --policy paper --time-scale 1000 --view",
      kUsualSize);
  // The paper's policy explores all arms, regardless of their costs.
  EXPECT_NE(program.ReadUntil(", because the policy measures "), std::string::npos)
      << program.output();
  program.Type(kCtrlC);
  EXPECT_EQ(program.Await(), 0);
}

TEST(ViewProgram, NoColorTurnsTheColoursOff) {
  // An empty value means the same as none (no-color.org).
  for (const auto& [value, has_colours] : {std::pair("1", false), std::pair("", true)}) {
    ProgramInTerminal program(kManualGame + std::string("--view --duration 300ms"), kUsualSize,
                              value);
    EXPECT_EQ(program.Await(), 0);
    EXPECT_THAT(program.output(), HasSubstr("▶ "));
    EXPECT_EQ(program.output().find("\x1b[38;5;") != std::string::npos, has_colours);
  }
}

}  // namespace
}  // namespace sweepstake::cli
