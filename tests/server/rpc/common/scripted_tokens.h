// Tokens that a test adds and revokes.
#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/auth/principal.h"

namespace sweepstake::rpc {

class ScriptedTokens final : public auth::TokenDirectory {
 public:
  // Adds the token "NAME-token".
  void Add(const std::string& name, auth::Role role, std::vector<std::string> projects = {}) {
    const std::lock_guard lock(mutex_);
    tokens_[name + "-token"] = {++last_id_, name, role, std::move(projects)};
  }
  void Revoke(const std::string& name) {
    const std::lock_guard lock(mutex_);
    tokens_.erase(name + "-token");
  }

  bool empty() const override {
    const std::lock_guard lock(mutex_);
    return last_id_ == 0;
  }
  std::optional<auth::Principal> Find(std::string_view token) const override {
    const std::lock_guard lock(mutex_);
    const auto found = tokens_.find(std::string(token));
    if (found == tokens_.end()) return std::nullopt;
    return found->second;
  }
  bool IsValid(const auth::Principal& caller) const override {
    const std::lock_guard lock(mutex_);
    ++checks_[caller.name];
    for (const auto& [token, holder] : tokens_) {
      if (holder.token_id == caller.token_id) return true;
    }
    return false;
  }
  // Returns how often calls under way have checked that the token of `name` is still valid.
  size_t CheckCount(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = checks_.find(name);
    return found == checks_.end() ? 0 : found->second;
  }

 private:
  mutable std::mutex mutex_;  // guards the members below
  mutable std::map<std::string, size_t> checks_;
  std::map<std::string, auth::Principal> tokens_;
  int64_t last_id_ = 0;
};

}  // namespace sweepstake::rpc
