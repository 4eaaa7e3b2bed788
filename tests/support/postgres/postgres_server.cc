#include "tests/support/postgres/postgres_server.h"

#include <libpq-fe.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <thread>
#include <vector>

namespace sweepstake::test_support {
namespace {

constexpr uid_t kNobody = 65534;
constexpr int kStartAttempts = 12'000;
constexpr auto kPause = std::chrono::milliseconds(5);

// Returns the command. For root, it changes the user, because PostgreSQL refuses to run as root.
std::vector<std::string> Command(const char* program, std::initializer_list<std::string> rest) {
  std::vector<std::string> command;
  if (geteuid() == 0)
    command = {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--"};
  command.push_back(std::string(SWEEPSTAKE_POSTGRES_BIN) + "/" + program);
  command.insert(command.end(), rest);
  return command;
}

[[noreturn]] void Abort(const std::string& what) {
  std::fprintf(stderr, "PostgreSQL: %s\n", what.c_str());
  std::abort();
}

}  // namespace

PostgresServer::PostgresServer(bool synced) : synced_(synced) {
  if (geteuid() == 0 && chown(directory_.path().c_str(), kNobody, kNobody) != 0)
    Abort("the owner of its directory cannot be changed");
  Make();
  Start();
}

PostgresServer::~PostgresServer() {
  if (!process_) return;
  process_->Signal(SIGQUIT);  // ends the server and its connections at once
  while (!process_->ended()) std::this_thread::sleep_for(kPause);
}

void PostgresServer::Make() {
  const auto log = directory_.path() / "initdb.log";
  ChildProcess initdb(Command("initdb", {"--pgdata=" + (directory_.path() / "data").string(),
                                         "--auth=trust", "--username=sweepstake", "--encoding=UTF8",
                                         "--locale=C", "--no-sync", "--no-instructions"}),
                      log);
  while (!initdb.ended()) std::this_thread::sleep_for(kPause);
  if (!std::filesystem::exists(directory_.path() / "data" / "PG_VERSION"))
    Abort("initdb has failed: " + initdb.log());
}

void PostgresServer::Start() {
  const std::string socket = directory_.path().string();
  const std::string url = "host=" + socket + " user=sweepstake dbname=postgres";
  for (int attempt = 0; attempt < kStartAttempts; ++attempt) {
    // A server refuses to start, and ends at once, while processes of a killed server still exist.
    if (!process_ || process_->ended()) {
      process_ = std::make_unique<ChildProcess>(
          Command("postgres", {"-D", socket + "/data", "-k", socket, "-c",
                               "listen_addresses=", "-c", synced_ ? "fsync=on" : "fsync=off", "-c",
                               synced_ ? "shared_buffers=128MB" : "shared_buffers=16MB", "-c",
                               synced_ ? "autovacuum=on" : "autovacuum=off"}),
          directory_.path() / "server.log");
    }
    if (PQping(url.c_str()) == PQPING_OK) return;
    std::this_thread::sleep_for(kPause);
  }
  Abort("the server does not answer: " + process_->log());
}

// The processes that serve connections notice the end of the main process later, possibly after
// another commit.
void PostgresServer::Kill() {
  const std::string first = std::to_string(process_->pid());
  std::ifstream list("/proc/" + first + "/task/" + first + "/children");
  const std::vector<pid_t> others{std::istream_iterator<pid_t>(list), {}};
  process_->Kill();
  for (const pid_t other : others) kill(other, SIGKILL);
  process_.reset();
}

std::string PostgresServer::NewDatabase() {
  const std::string server = "host=" + directory_.path().string() + " user=sweepstake dbname=";
  const std::string name = "test_" + std::to_string(++database_count_);
  PGconn* connection = PQconnectdb((server + "postgres").c_str());
  PGresult* result = PQexec(connection, ("CREATE DATABASE " + name).c_str());
  if (PQresultStatus(result) != PGRES_COMMAND_OK) Abort(PQerrorMessage(connection));
  PQclear(result);
  PQfinish(connection);
  return "postgresql://sweepstake@/" + name + "?host=" + directory_.path().string();
}

}  // namespace sweepstake::test_support
