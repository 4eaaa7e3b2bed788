#include "server/program.h"

#include <fcntl.h>
#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <malloc.h>
#include <pthread.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "engine_client/text/counts.h"
#include "engine_client/text/names.h"
#include "server/config.h"
#include "server/daemon.h"
#include "server/host/exit_guard.h"
#include "server/host/grpc_log.h"
#include "server/host/service_manager.h"
#include "server/rpc/health_probe.h"
#include "server/sessions/common/decision_loop.h"
#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/data_directory.h"
#include "server/storage/postgres/shared_store.h"
#include "server/token_command.h"

namespace sweepstake::server {
namespace {

constexpr int kDone = 0;
constexpr int kCheckFailed = 1;
constexpr int kBadUsage = 2;
constexpr int kCouldNotStart = 3;
constexpr int kDidNotEnd = 4;

constexpr const char* kToStore = "to-store";
constexpr const char* kToData = "to-data";

constexpr std::chrono::seconds kEndPatience{9};
constexpr std::chrono::seconds kProbePatience{5};

constexpr std::string_view kNoWatchdog =
    "the watchdog cannot connect to the daemon's own listener; with --tls-client-ca, that "
    "authority must accept the daemon's certificate as a client certificate too";

struct CommandLine {
  CommandLine(int count, char** words) : argc(count), argv(words) {}

  // Parses the command line. Flags override values already in `config`. Throws CLI::Error.
  void Parse() { app.parse(argc, argv); }

  const int argc;
  char** const argv;
  CLI::App app{
      "The decision daemon of Sweepstake: learns which broad phase suits a scene, and sends switch "
      "commands to games.",
      "sweepstaked"};
  Config config;
  Settings settings{app, config};
  std::string config_file;
  std::string file;       // argument FILE of a subcommand
  std::string direction;  // argument of `migrate`
  bool verify = false;
  bool print_config = false;
  TokenCommand token;
};

void AddOptions(CommandLine& line) {
  CLI::App& app = line.app;
  app.set_version_flag("--version", SWEEPSTAKE_VERSION);
  app.add_option("--config", line.config_file, "TOML file with any of the settings below");
  app.add_flag("--print-config", line.print_config,
               "print the configuration in effect, as TOML, and exit");
  CLI::App* check =
      app.add_subcommand("check-config", "check a configuration file and exit: 0 valid, 1 not");
  check->add_option("file", line.file, "the TOML file")->required();
  CLI::App* backup = app.add_subcommand(
      "backup", "copy the priors and the audit log to a new file; the daemon may be running");
  backup->add_option("file", line.file, "the file to write; - for standard output")->required();
  backup->fallthrough();
  backup->footer(
      "The backup also contains the tokens' digests and the resume key, so keep it secret.\n"
      "Example: sweepstaked backup priors-monday.db --data /var/lib/sweepstake\n"
      "         sweepstaked backup - | ssh other-host 'cat > priors-monday.db'");
  CLI::App* restore = app.add_subcommand(
      "restore", "check a backup and copy it into a data directory that has no store");
  restore->add_option("file", line.file, "the file that `backup` wrote")->required();
  restore->add_flag("--verify", line.verify, "only check the backup and print what it contains");
  restore->fallthrough();
  restore->footer("Example: sweepstaked restore priors-monday.db --data /var/lib/sweepstake");
  CLI::App* migrate = app.add_subcommand(
      "migrate",
      "copy priors.db into the shared store, or back; stop every daemon that uses them first");
  migrate->add_option("direction", line.direction, "to-store or to-data")
      ->required()
      ->check(CLI::IsMember({kToStore, kToData}));
  migrate->fallthrough();
  migrate->footer(
      "Examples: sweepstaked migrate to-store --data /var/lib/sweepstake --store "
      "postgresql://sweepstake@db.example/sweepstake\n"
      "          sweepstaked migrate to-data --store "
      "postgresql://sweepstake@db.example/sweepstake --data /var/lib/sweepstake-of-one");
  CLI::App* probe = app.add_subcommand(
      "probe", "check the health of the daemon with this configuration and exit: 0 serving, 1 not");
  probe->fallthrough();
  probe->footer(
      "Calls grpc.health.v1 at `listen`; if its port is 0, at the port in `port_file`. For "
      "containers without a shell: HEALTHCHECK CMD [\"sweepstaked\", \"probe\"]");
  line.token.AddTo(app);
  app.footer("Example: sweepstaked --listen 127.0.0.1:7433 --data /var/lib/sweepstake");
  app.require_subcommand(0, 1);
  app.allow_extras();
}

// Prints the message, which may have several lines, to stderr. Returns `code`.
int Fail(int code, std::string_view message) {
  std::istringstream lines{std::string(message)};
  for (std::string line; std::getline(lines, line);) std::cerr << "sweepstaked: " << line << '\n';
  return code;
}

std::vector<std::string> Environment() {
  std::vector<std::string> entries;
  for (char** entry = environ; *entry != nullptr; ++entry) entries.emplace_back(*entry);
  return entries;
}

absl::StatusOr<Config> Load(CommandLine& line) {
  line.config = Config();
  absl::Status status;
  if (!line.config_file.empty()) status = line.settings.ReadFile(line.config_file);
  if (status.ok()) status = line.settings.ReadEnvironment(Environment());
  if (!status.ok()) return status;
  line.Parse();
  status = Validate(line.config);
  if (!status.ok()) return status;
  return line.config;
}

int CheckConfig(const std::string& file) {
  const absl::Status status = CheckConfigFile(file);
  if (!status.ok()) return Fail(kCheckFailed, std::string(status.message()));
  std::cout << file << ": ok\n";
  return kDone;
}

int ReportContents(const std::string& file, const absl::StatusOr<storage::StoreContents>& contents,
                   std::ostream& out = std::cout) {
  if (!contents.ok()) return Fail(kCheckFailed, std::string(contents.status().message()));
  out << file << ": undamaged; " << text::Counted(contents->record_count, "record") << " of "
      << text::Counted(contents->source_count, "source") << " about "
      << text::Counted(contents->scene_count, "scene") << ", "
      << text::Counted(contents->audit_row_count, "row") << " of the audit log";
  for (const std::string& name : contents->kept_files) out << ", " << name;
  out << '\n';
  if (contents->damaged_row_count == 0) return kDone;
  return Fail(kCheckFailed, absl::StrCat(contents->damaged_row_count,
                                         " damaged rows of the database are not in ", file,
                                         "; check the disk, and restore this or an earlier "
                                         "backup"));
}

// Writes a backup to standard output. It is first made beside the database, because a copy that
// cannot be verified must not be written.
int BackUpToOutput(const Config& config) {
  const std::filesystem::path file =
      config.data / absl::StrCat(storage::DataDirectory::kDatabaseName, ".new-", getpid());
  const auto contents = storage::BackUpStore(config.data, file);
  std::ifstream copy(file, std::ios::binary);
  std::error_code ignored;
  std::filesystem::remove(file, ignored);  // the open file can still be read
  std::signal(SIGPIPE, SIG_IGN);
  // After a write that fails, some of the copy is left.
  if (contents.ok() && (!(std::cout << copy.rdbuf() << std::flush) || copy.peek() >= 0))
    return Fail(kCheckFailed,
                "cannot write the whole backup to standard output; what was written is useless");
  return ReportContents("standard output", contents, std::cerr);
}

int Migrate(const Config& config, bool to_store) {
  const auto print = [](const std::string& table, uint64_t rows, uint64_t total) {
    std::cerr << "sweepstaked: " << table << ": " << rows << " of " << total << " rows\n";
  };
  return ReportContents(to_store ? config.store : config.data.string(),
                        storage::MigrateStore(config.data, config.store, to_store, print));
}

// Returns the address that the daemon of this configuration listens on.
absl::StatusOr<std::string> AddressOf(const Config& config) {
  if (!config.listen.ends_with(":0")) return config.listen;
  int port = 0;
  if (std::ifstream(config.port_file) >> port)
    return config.listen.substr(0, config.listen.size() - 1) + std::to_string(port);
  return absl::NotFoundError(
      "the port of the daemon is unknown; name it with --listen, or name the daemon's --port-file");
}

int Probe(const Config& config) {
  const auto address = AddressOf(config);
  if (!address.ok()) return Fail(kCheckFailed, std::string(address.status().message()));
  const auto health = rpc::ProbeHealth(*address, config.rpc.tls, kProbePatience);
  if (!health.ok())
    return Fail(kCheckFailed,
                *address + ": no daemon answered: " + std::string(health.status().message()));
  if (*health == rpc::Health::kNotServing)
    return Fail(kCheckFailed, *address + ": not serving; its log has the reason");
  std::cout << *address << ": serving\n";
  return kDone;
}

// Exits without destructors: threads of gRPC may still be closing the connection, and exit() would
// unload libraries that they use.
[[noreturn]] void EndBesideThreads(int code) {
  std::cout.flush();
  std::_Exit(code);
}

// Returns the program's app, followed by the subcommand on the command line and its own subcommand,
// if given.
std::vector<const CLI::App*> GivenCommands(const CLI::App& app) {
  std::vector<const CLI::App*> given = {&app};
  while (!given.back()->get_subcommands().empty())
    given.push_back(given.back()->get_subcommands().front());
  return given;
}

std::string UnknownOption(const std::vector<const CLI::App*>& given, std::string_view word) {
  std::vector<std::string> names;
  for (const CLI::App* command : given) {
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  const std::vector<std::string_view> known(names.begin(), names.end());
  return text::UnknownNameOfMany("option", word.substr(0, word.find('=')), known);
}

// Returns the error message for the first word that no option or command accepts.
std::string UnknownWord(const CLI::App& app) {
  const std::string word = app.remaining(/*recurse=*/true).front();
  const std::vector<const CLI::App*> given = GivenCommands(app);
  if (word.starts_with('-')) return UnknownOption(given, word);
  const CLI::App& command = *given.back();
  std::vector<std::string> names;
  for (const CLI::App* each : command.get_subcommands({})) names.push_back(each->get_name());
  if (names.empty()) {
    return command.get_name() + ": unexpected argument '" + text::PrintableLine(word) +
           "'; --help lists the arguments";
  }
  const std::vector<std::string_view> known(names.begin(), names.end());
  return text::UnknownName("command of " + command.get_name(), word, known);
}

// Blocks the signals before any thread starts, so that only sigwait receives them.
sigset_t BlockSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Returns freed memory to the system, which glibc does for the end of each arena only. After a
// flood of calls, most of it would stay.
void TrimMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

// Waits for SIGTERM or SIGINT. SIGHUP reloads the configuration. Trims the memory each minute.
void AwaitEnd(const sigset_t& signals, CommandLine& line, Daemon& daemon) {
  constexpr timespec kMinute = {.tv_sec = 60, .tv_nsec = 0};
  for (;;) {
    const int signal = sigtimedwait(&signals, nullptr, &kMinute);
    if (signal == SIGHUP) {
      daemon.Reload(Load(line));
    } else if (signal > 0) {
      return;
    } else if (errno == EAGAIN) {
      TrimMemory();
    }
  }
}

// Opens /dev/null for each closed standard stream. Otherwise the next file that the program opens
// would take its number: with 2>&- the log would be written into a file of the data directory.
// Writing to a closed standard output stays an error.
void OpenStandardStreams() {
  for (int file = STDIN_FILENO; file <= STDERR_FILENO; ++file) {
    if (fcntl(file, F_GETFD) < 0) open("/dev/null", file == STDOUT_FILENO ? O_RDONLY : O_RDWR);
  }
}

// SQLite maps its -shm file. An access beyond the end of a file that was cut raises SIGBUS. What
// was acknowledged is in the database, so a restart continues.
extern "C" void OnBusError(int /*signal*/) {
  constexpr std::string_view kText =
      "sweepstaked: a file of the data directory was cut while it was in use, or its disk does not "
      "answer; start the daemon again\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kText.data(), kText.size());
  _exit(kDidNotEnd);
}

int Run(const Config& config, CommandLine& line) {
  const sigset_t signals = BlockSignals();
  // A closed log pipe must not end the daemon.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGBUS, OnBusError);
  // gRPC and protobuf write lines to stderr that are not JSON. GrpcLog takes those of gRPC later.
  gpr_set_log_function([](gpr_log_func_args* /*line*/) {});
  // protobuf writes a line for each text that is not UTF-8, so clients could cause any number of
  // lines.
  google::protobuf::SetLogHandler(nullptr);
  // Disables a check that some builds of Abseil enable: it searches gRPC's mutexes for deadlocks,
  // under one lock for all threads.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  std::optional<ExitGuard> guard;  // outlives the daemon
  sessions::SteadyLoopClock clock;
  auto daemon = Daemon::Start(config, clock);
  if (!daemon.ok()) return Fail(kCouldNotStart, std::string(daemon.status().message()));
  const GrpcLog grpc_log((*daemon)->log());
  const auto interval = WatchdogInterval();
  if (interval && !(*daemon)->Alive(*interval)) return Fail(kCouldNotStart, kNoWatchdog);
  const Watchdog watchdog(interval, [&] { return (*daemon)->Alive(*interval); });
  NotifyReady();
  AwaitEnd(signals, line, **daemon);
  NotifyStopping();
  const auto must_wait = [saving = (*daemon)->saving()] {
    if (*saving) NotifyStoppingTakes(2 * kEndPatience);
    return saving->load();
  };
  guard.emplace(kEndPatience, kDidNotEnd,
                "sweepstaked: did not end in time: the disk does not answer, or clients flood the "
                "daemon with calls. It exits without waiting; clients send unacknowledged evidence "
                "again",
                must_wait);
  (*daemon)->Drain();
  return kDone;
}

}  // namespace

int RunProgram(int argc, char** argv) {
  OpenStandardStreams();
  // At a limit of the file size (ulimit -f) writes fail as on a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  CommandLine line(argc, argv);
  CLI::App& app = line.app;
  AddOptions(line);
  // CLI11 would read --insecure= as --insecure, and the next word as the value of --listen=.
  for (const std::string_view word : std::span(argv, argv + argc)) {
    if (word.starts_with("--") && word.find('=') == word.size() - 1)
      return Fail(kBadUsage, absl::StrCat(std::string(word), " has no value"));
  }
  try {
    line.Parse();
  } catch (const CLI::Success& request) {
    return app.exit(request);  // --help or --version
  } catch (const CLI::ParseError& error) {
    // If a required option is missing and there is an unknown word, the word may be that option,
    // misspelt. UnknownWord reports it below.
    if (app.remaining(/*recurse=*/true).empty()) return Fail(kBadUsage, error.what());
  }
  if (!app.remaining(/*recurse=*/true).empty()) return Fail(kBadUsage, UnknownWord(app));
  if (app.got_subcommand("check-config")) return CheckConfig(line.file);
  const auto config = Load(line);
  if (!config.ok()) return Fail(kBadUsage, std::string(config.status().message()));
  if (line.print_config) {
    std::cout << PrintConfig(*config);
    return kDone;
  }
  if (app.got_subcommand("probe")) EndBesideThreads(Probe(*config));
  if (line.token.parsed()) {
    const absl::Status status = line.token.Run(config->data, std::cout, std::cerr);
    return status.ok() ? kDone : Fail(kCheckFailed, std::string(status.message()));
  }
  if (app.got_subcommand("backup") && line.file == "-") return BackUpToOutput(*config);
  if (app.got_subcommand("backup"))
    return ReportContents(line.file, storage::BackUpStore(config->data, line.file));
  if (app.got_subcommand("migrate")) return Migrate(*config, line.direction == kToStore);
  if (app.got_subcommand("restore")) {
    return ReportContents(line.file, line.verify ? storage::VerifyStore(line.file)
                                                 : storage::RestoreStore(line.file, config->data));
  }
  return Run(*config, line);
}

}  // namespace sweepstake::server
