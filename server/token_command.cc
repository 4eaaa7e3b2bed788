#include "server/token_command.h"

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "engine_client/text/names.h"
#include "server/auth/ticket.h"
#include "server/auth/token_store.h"
#include "server/sessions/common/unix_time.h"
#include "server/storage/data_directory.h"

namespace sweepstake::server {
namespace {

namespace fs = std::filesystem;
using auth::StoredToken;
using auth::TokenStore;
using Json = nlohmann::ordered_json;

constexpr int64_t kSecondsPerDay = 86'400;
constexpr int64_t kSecondsPerHour = 3'600;

// Returns the name of the user who runs the command; the token list shows it.
std::string UserName() {
  std::array<char, 4096> buffer{};
  passwd user{};
  passwd* found = nullptr;
  if (getpwuid_r(getuid(), &user, buffer.data(), buffer.size(), &found) == 0 && found != nullptr &&
      text::IsName(found->pw_name))
    return found->pw_name;
  return absl::StrCat("uid ", getuid());
}

absl::Status CannotCreate(const fs::path& path, int why) {
  return absl::UnavailableError(
      absl::StrCat("cannot create ", path.string(), ": ", std::generic_category().message(why)));
}

// Opens the token file in `data`. Creates it if it is missing, even if an earlier token file was
// lost.
absl::StatusOr<TokenStore> CreateStore(const fs::path& data) {
  if (mkdir(data.c_str(), 0700) != 0 && errno != EEXIST) return CannotCreate(data, errno);
  return TokenStore::Open(data / storage::DataDirectory::kTokensName, TokenStore::IfLost::kReplace);
}

// Opens the token file in `data`. Returns an error if `data` never had one, because the directory
// may not belong to a daemon.
absl::StatusOr<TokenStore> OpenStore(const fs::path& data) {
  const fs::path tokens = data / storage::DataDirectory::kTokensName;
  if (TokenStore::IsKnown(tokens)) return TokenStore::Open(tokens);
  std::error_code unknown;
  if (!fs::exists(data, unknown) && !unknown) {
    return absl::NotFoundError(absl::StrCat("there is no directory ", data.string(),
                                            "; name the daemon's directory with --data"));
  }
  if (!fs::exists(tokens, unknown) && unknown)
    return absl::UnavailableError(absl::StrCat(tokens.string(), ": ", unknown.message()));
  return absl::NotFoundError(absl::StrCat("there are no tokens in ", data.string(),
                                          "; name the daemon's directory with --data"));
}

std::string_view StateOf(const StoredToken& token, int64_t now_s) {
  if (token.revoked_unix_s) return "revoked";
  return token.IsValidAt(now_s) ? "valid" : "expired";
}

std::string DateText(const std::optional<int64_t>& unix_s) {
  if (!unix_s) return "never";
  const time_t time = *unix_s;
  tm parts{};
  gmtime_r(&time, &parts);
  return absl::StrFormat("%04d-%02d-%02d", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday);
}

std::string ProjectsText(const StoredToken& token) {
  if (token.request.projects.empty()) return "*";
  return absl::StrJoin(token.request.projects, ",");
}

Json OrNull(const std::optional<int64_t>& unix_s) { return unix_s ? Json(*unix_s) : Json(); }

Json JsonOf(const StoredToken& token, int64_t now_s) {
  const auto& projects = token.request.projects;
  return {{"id", token.id},
          {"name", token.request.name},
          {"role", auth::NameOf(token.request.role)},
          {"projects", projects.empty() ? std::vector<std::string>{"*"} : projects},
          {"state", StateOf(token, now_s)},
          {"created_unix_s", token.created_unix_s},
          {"created_by", token.request.made_by},
          {"expires_unix_s", OrNull(token.request.expires_unix_s)},
          {"last_used_unix_s", OrNull(token.last_used_unix_s)},
          {"revoked_unix_s", OrNull(token.revoked_unix_s)},
          {"revoked_by", token.revoked_unix_s ? Json(token.revoked_by) : Json()}};
}

// A new file that only its owner can read.
class SecretFile {
 public:
  explicit SecretFile(const fs::path& path)
      : file_(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600)) {}
  ~SecretFile() {
    if (file_ >= 0) close(file_);
  }
  SecretFile(const SecretFile&) = delete;
  SecretFile& operator=(const SecretFile&) = delete;

  bool made() const { return file_ >= 0; }
  bool Write(const std::string& text) const {
    return write(file_, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
           fsync(file_) == 0;
  }

 private:
  const int file_;
};

}  // namespace

void TokenCommand::AddTo(CLI::App& app) {
  CLI::App* const token = token_ =
      app.add_subcommand("token", "create, list and revoke the tokens that clients must send");
  token->require_subcommand(1);
  token->fallthrough();
  create_ = token->add_subcommand("create", "create a token and print it once");
  create_->add_option("name", name_, "its name in lists and in the log")->required();
  create_
      ->add_option("--role", role_,
                   "player: games that players have; ticket: signs the tickets of players; ingest: "
                   "games of the studio, which may add scenes and arms; watch: reads; operator: "
                   "watch and operate; admin: everything")
      ->required()
      ->check(CLI::IsMember(
          std::vector<std::string>(auth::kRoleNames.begin(), auth::kRoleNames.end())));
  create_->add_option("--project", projects_,
                      "a project that it allows; may be repeated; default: all projects");
  create_->add_option("--days", days_, "days until it expires; default: never")
      ->check(CLI::Range(1, 36'500));
  create_->add_option("--out", out_file_, "new file for the token, instead of standard output");
  create_->fallthrough();
  create_->footer(
      "Example: sweepstaked token create arcade --role ingest --project arcade --days 365 --out "
      "arcade.token --data /var/lib/sweepstake");
  list_ =
      token->add_subcommand("list", "list the tokens, without their secrets, which are not stored");
  list_->add_flag("--json", json_, "print JSON");
  list_->fallthrough();
  list_->footer("Example: sweepstaked token list --json --data /var/lib/sweepstake");
  CLI::App* revoke = token->add_subcommand("revoke", "revoke a token");
  revoke->add_option("name", name_, "the token's name")->required();
  revoke->fallthrough();
  revoke->footer("Example: sweepstaked token revoke arcade --data /var/lib/sweepstake");
  ticket_ = app.add_subcommand(
      "ticket", "sign a ticket, with which one player may use a game's token, and print it");
  ticket_->add_option("player", player_, "the player: letters, digits, '-' and '_'")->required();
  ticket_->add_option("--token-file", token_file_, "file with a token of the role ticket")
      ->required();
  ticket_->add_option("--hours", hours_, "hours until the ticket expires")
      ->check(CLI::Range(int64_t{1}, auth::kMaxTicketLifeS / kSecondsPerHour))
      ->capture_default_str();
  ticket_->footer(
      "For tests: a studio's backend signs tickets itself (deploy/OPERATING.md, Tickets).\n"
      "Example: sweepstaked ticket player-17 --token-file arcade.token --hours 12");
}

absl::Status TokenCommand::Run(const fs::path& data, std::ostream& out, std::ostream& notes) const {
  if (ticket_->parsed()) return Sign(out);
  if (create_->parsed()) return Create(data, out, notes);
  return list_->parsed() ? List(data, out) : Revoke(data, out);
}

absl::Status TokenCommand::Create(const fs::path& data, std::ostream& out,
                                  std::ostream& notes) const {
  const int64_t now_s = priors::UnixNowS();
  const auto* const role = std::find(auth::kRoleNames.begin(), auth::kRoleNames.end(), role_);
  auth::TokenRequest request = {.name = name_,
                                .role = static_cast<auth::Role>(role - auth::kRoleNames.begin()),
                                .projects = projects_,
                                .expires_unix_s = std::nullopt,
                                .made_by = UserName()};
  if (days_) request.expires_unix_s = now_s + *days_ * kSecondsPerDay;
  auto store = CreateStore(data);
  if (!store.ok()) return store.status();
  if (out_file_.empty()) {
    const auto token = store->Create(request, now_s);
    if (!token.ok()) return token.status();
    out << *token << '\n' << std::flush;
    std::error_code unknown;  // the path is printed as given if it cannot be made absolute
    fs::path whole = fs::absolute(data, unknown);
    if (unknown) whole = data;
    notes << "token " << text::PrintableLine(name_) << " is in "
          << (whole / storage::DataDirectory::kTokensName).string()
          << "; it is shown only this once; the daemon of that directory accepts it\n";
    if (out) return absl::OkStatus();
    return absl::UnavailableError("cannot print the token; revoke it and create another one");
  }
  const SecretFile file(out_file_);
  if (!file.made()) return CannotCreate(out_file_, errno);
  const auto token = store->Create(request, now_s);
  if (token.ok() && file.Write(*token + '\n')) {
    out << out_file_.string() << ": token " << text::PrintableLine(name_) << " of " << data.string()
        << '\n';
    return absl::OkStatus();
  }
  std::error_code ignored;
  fs::remove(out_file_, ignored);
  if (!token.ok()) return token.status();
  return absl::UnavailableError(absl::StrCat("cannot write ", out_file_.string(),
                                             "; revoke the token and create another one"));
}

absl::Status TokenCommand::Sign(std::ostream& out) const {
  if (!auth::IsPlayer(player_))
    return absl::InvalidArgumentError("a player has 1 to 64 letters, digits, '-' and '_'");
  std::string token;
  std::ifstream file(token_file_);
  if (!(file >> token) || !auth::IsToken(token))
    return absl::UnavailableError(absl::StrCat("cannot read a token from ", token_file_.string()));
  out << auth::SignTicket(token, player_, priors::UnixNowS() + hours_ * kSecondsPerHour) << '\n'
      << std::flush;
  return out ? absl::OkStatus() : absl::UnavailableError("cannot print the ticket");
}

absl::Status TokenCommand::List(const fs::path& data, std::ostream& out) const {
  auto store = OpenStore(data);
  if (!store.ok()) return store.status();
  const auto tokens = store->Load();
  if (!tokens.ok()) return tokens.status();
  const int64_t now_s = priors::UnixNowS();
  if (json_) {
    Json list = Json::array();
    for (const StoredToken& token : *tokens) list.push_back(JsonOf(token, now_s));
    out << list.dump(2) << '\n';
    return absl::OkStatus();
  }
  constexpr const char* kRow = "%4s  %-24s  %-8s  %-7s  %-10s  %-10s  %-10s  %s\n";
  const auto row = absl::ParsedFormat<'s', 's', 's', 's', 's', 's', 's', 's'>::New(kRow);
  out << absl::StrFormat(*row, "ID", "NAME", "ROLE", "STATE", "CREATED", "EXPIRES", "LAST USED",
                         "PROJECTS");
  for (const StoredToken& token : *tokens) {
    out << absl::StrFormat(*row, absl::StrCat(token.id), text::PrintableLine(token.request.name),
                           std::string(auth::NameOf(token.request.role)),
                           std::string(StateOf(token, now_s)), DateText(token.created_unix_s),
                           DateText(token.request.expires_unix_s), DateText(token.last_used_unix_s),
                           ProjectsText(token));
  }
  return absl::OkStatus();
}

absl::Status TokenCommand::Revoke(const fs::path& data, std::ostream& out) const {
  auto store = OpenStore(data);
  if (!store.ok()) return store.status();
  absl::Status status = store->Revoke(name_, UserName(), priors::UnixNowS());
  if (status.ok()) {
    out << text::PrintableLine(name_) << ": revoked; a running daemon ends its streams within "
        << "five seconds\n";
  }
  return status;
}

}  // namespace sweepstake::server
