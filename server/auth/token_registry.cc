#include "server/auth/token_registry.h"

#include <openssl/crypto.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "engine_client/text/names.h"
#include "server/auth/ticket.h"

namespace sweepstake::auth {
namespace {

std::string NameFor(const StoredToken& token) { return text::PrintableLine(token.request.name); }

std::string MadeText(const StoredToken& token) {
  const TokenRequest& request = token.request;
  return absl::StrCat("token ", NameFor(token), " was created by ",
                      text::PrintableLine(request.made_by), ", role ",
                      std::string(NameOf(request.role)), ", for ",
                      request.projects.empty() ? "all projects" : "some projects");
}

// Returns whether the list has the token at this index. Tokens are only appended to the file, so a
// token keeps its index. A file that has replaced it may have another token at this index.
template <typename Entry>
bool HasAt(const std::vector<Entry>& list, size_t place, const StoredToken& token) {
  return place < list.size() && list[place].token.id == token.id &&
         list[place].token.digest == token.digest;
}

}  // namespace

absl::StatusOr<std::unique_ptr<TokenRegistry>> TokenRegistry::Open(
    const std::filesystem::path& path, TokenRegistryOptions options) {
  std::unique_ptr<TokenRegistry> registry(new TokenRegistry(path, std::move(options)));
  if (absl::Status status = registry->OpenStore(); !status.ok()) return status;
  registry->next_use_store_ = std::chrono::steady_clock::now() + registry->options_.use_interval;
  registry->thread_ = std::thread([raw = registry.get()] { raw->Run(); });
  return registry;
}

TokenRegistry::~TokenRegistry() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ending_changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::shared_ptr<const TokenRegistry::Entries> TokenRegistry::Current() const {
  const std::lock_guard lock(mutex_);
  return entries_;
}

std::optional<Principal> TokenRegistry::Find(std::string_view token) const {
  const int64_t now_s = options_.unix_now_s();
  const auto ticket = ReadTicket(token);
  if (ticket && !ticket->IsValidAt(now_s)) return std::nullopt;
  const std::string digest = DigestOf(token);
  const auto entries = Current();
  const Entry* found = nullptr;
  const auto [first, last] =
      entries->by_digest.equal_range(ticket ? ticket->key : digest.substr(0, kTicketKeyDigits));
  for (auto place = first; place != last; ++place) {
    const Entry& entry = entries->list[place->second];
    const std::string& stored = entry.token.digest;
    if (ticket ? entry.token.request.role == Role::kTicket && IsSignedWith(token, stored)
               : CRYPTO_memcmp(stored.data(), digest.data(), digest.size()) == 0) {
      found = &entry;
    }
  }
  if (found == nullptr || !found->token.IsValidAt(now_s)) return std::nullopt;
  *found->last_used_unix_s = now_s;
  const TokenRequest& request = found->token.request;
  const Role role = ticket ? Role::kPlayer : request.role;
  return Principal{found->token.id,  request.name,        role,
                   request.projects, found->token.digest, ticket ? ticket->player : ""};
}

bool TokenRegistry::IsValid(const Principal& holder) const {
  const auto entries = Current();
  const auto found =
      std::lower_bound(entries->list.begin(), entries->list.end(), holder.token_id,
                       [](const Entry& entry, int64_t id) { return entry.token.id < id; });
  return found != entries->list.end() && found->token.id == holder.token_id &&
         found->token.digest == holder.digest && found->token.IsValidAt(options_.unix_now_s());
}

absl::Status TokenRegistry::OpenStore() {
  auto store = TokenStore::Open(path_);
  if (!store.ok()) return store.status();
  store_.emplace(*std::move(store));
  const auto version = store_->Version();
  if (!version.ok()) return version.status();
  version_ = *version;
  return Read();
}

absl::Status TokenRegistry::Read() {
  auto tokens = store_->Load();
  if (!tokens.ok()) return tokens.status();
  if (tokens->empty() && (store_->WereMade() || !empty())) return store_->Lost();
  const auto before = Current();
  Entries after;
  for (StoredToken& token : *tokens) {
    const size_t i = after.list.size();
    const bool known = HasAt(before->list, i, token);
    auto last_used =
        known ? before->list[i].last_used_unix_s
              : std::make_shared<std::atomic<int64_t>>(token.last_used_unix_s.value_or(0));
    after.by_digest.emplace(token.digest.substr(0, kTicketKeyDigits), i);
    after.list.push_back({std::move(token), std::move(last_used)});
  }
  if (thread_.joinable()) Report(*before, after);
  const std::lock_guard lock(mutex_);
  entries_ = std::make_shared<const Entries>(std::move(after));
  return absl::OkStatus();
}

void TokenRegistry::Report(const Entries& before, const Entries& after) const {
  for (size_t i = 0; i < before.list.size(); ++i) {
    const StoredToken& token = before.list[i].token;
    if (!HasAt(after.list, i, token))
      options_.on_change(absl::StrCat("token ", NameFor(token), " was removed from the file"));
  }
  for (size_t i = 0; i < after.list.size(); ++i) {
    const StoredToken& token = after.list[i].token;
    const bool known = HasAt(before.list, i, token);
    if (!known) options_.on_change(MadeText(token));
    if (token.revoked_unix_s && !(known && before.list[i].token.revoked_unix_s)) {
      options_.on_change(absl::StrCat("token ", NameFor(token), " was revoked by ",
                                      text::PrintableLine(token.revoked_by)));
    }
  }
}

void TokenRegistry::Run() {
  bool ending = false;
  while (!ending) {
    {
      std::unique_lock lock(mutex_);
      ending = ending_changed_.wait_for(lock, options_.interval, [this] { return ending_; });
    }
    LookAtFile();
    const auto now = std::chrono::steady_clock::now();
    if (!ending && now < next_use_store_) continue;
    next_use_store_ = now + options_.use_interval;
    StoreUses();
  }
}

void TokenRegistry::LookAtFile() {
  const absl::Status status = Follow();
  if (!status.ok() && readable_) options_.on_problem(status);
  readable_ = status.ok();
}

absl::Status TokenRegistry::Follow() {
  const auto in_place = store_->IsInPlace();
  if (!in_place.ok()) return in_place.status();
  if (!*in_place) return OpenStore();
  const auto version = store_->Version();
  if (!version.ok()) return version.status();
  // After a failed read, read again although the version is the same.
  if (readable_ && *version == version_) return absl::OkStatus();
  if (absl::Status status = Read(); !status.ok()) return status;
  version_ = *version;
  return absl::OkStatus();
}

void TokenRegistry::StoreUses() {
  const auto entries = Current();
  std::vector<std::pair<int64_t, int64_t>> uses;
  for (const Entry& entry : entries->list) {
    const int64_t used_s = *entry.last_used_unix_s;
    if (used_s != entry.token.last_used_unix_s.value_or(0))
      uses.emplace_back(entry.token.id, used_s);
  }
  if (uses.empty()) return;
  // A failed update is tried again after use_interval.
  absl::Status status = store_->MarkUsed(uses);
  if (status.ok()) status = Read();
  status.IgnoreError();
}

}  // namespace sweepstake::auth
