#include "server/alerts/alert_board.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sweepstake::alerts {
namespace {

constexpr int kSilencesVersion = 1;

bool HasEnded(const Silence& silence, int64_t unix_now_ms) {
  return silence.unix_until_ms > 0 && silence.unix_until_ms <= unix_now_ms;
}

// The first alerts have the lowest value.
auto RankOf(const Finding& finding, bool is_silenced) {
  return std::tuple(is_silenced, finding.severity != Severity::kSerious,
                    -finding.loss_us.value_or(0), -static_cast<int64_t>(finding.session_count));
}

}  // namespace

AlertChanges AlertBoard::Update(std::map<AlertKey, Finding> findings, int64_t now_ns,
                                int64_t unix_now_ms) {
  for (auto& [key, finding] : findings) {
    const auto found = entries_.find(key);
    if (found == entries_.end() && entries_.size() >= kMaxAlerts) continue;
    const auto [entry, is_new] = entries_.try_emplace(key);
    if (is_new) {
      entry->second.id = IdOf(key);
      entry->second.first_held_ns = now_ns;
      entry->second.unix_since_ms = unix_now_ms;
    }
    entry->second.finding = std::move(finding);
    entry->second.last_held_ns = now_ns;
  }
  AlertChanges changes;
  std::erase_if(entries_, [&](auto& each) {
    auto& [key, entry] = each;
    const int64_t absent_ns = now_ns - entry.last_held_ns;
    if (entry.begun ? absent_ns < kEndAfterNs : absent_ns == 0) return false;
    if (entry.announced) changes.ended.push_back(AlertOf(key, entry));
    const auto silence = silences_.find(entry.id);
    if (entry.begun && silence != silences_.end() && silence->second.silence.unix_until_ms == 0)
      RemoveSilence(silence);
    return true;
  });
  EndSilences(now_ns, unix_now_ms);
  for (auto& [key, entry] : entries_) {
    entry.begun = entry.begun || now_ns - entry.first_held_ns >= BeginAfterNs(key.rule);
    const bool is_silenced = silences_.contains(entry.id);
    const bool is_new = !entry.announced || entry.was_silenced;
    entry.was_silenced = is_silenced;
    if (!entry.begun || is_silenced || !is_new) continue;
    entry.announced = true;
    changes.begun.push_back(AlertOf(key, entry));
  }
  Rank();
  return changes;
}

Alert AlertBoard::AlertOf(const AlertKey& key, const Entry& entry) const {
  Alert alert = {
      .id = entry.id, .key = key, .finding = entry.finding, .unix_since_ms = entry.unix_since_ms};
  if (const auto found = silences_.find(entry.id); found != silences_.end())
    alert.silence = found->second.silence;
  return alert;
}

void AlertBoard::RemoveSilence(std::map<std::string, Kept>::iterator silence) {
  silences_.erase(silence);
  silences_changed_ = true;
}

void AlertBoard::EndSilences(int64_t now_ns, int64_t unix_now_ms) {
  for (const auto& [key, entry] : entries_) {
    if (const auto found = silences_.find(entry.id); found != silences_.end())
      found->second.last_needed_ns = now_ns;
  }
  const size_t removed = std::erase_if(silences_, [&](const auto& each) {
    const Kept& kept = each.second;
    return HasEnded(kept.silence, unix_now_ms) ||
           (kept.silence.unix_until_ms == 0 && now_ns - kept.last_needed_ns >= kForgetSilenceNs);
  });
  silences_changed_ = silences_changed_ || removed > 0;
}

void AlertBoard::Rank() {
  using Begun = const std::pair<const AlertKey, Entry>*;
  std::vector<std::pair<decltype(RankOf({}, false)), Begun>> order;
  for (const auto& each : entries_) {
    const Entry& entry = each.second;
    if (entry.begun) order.emplace_back(RankOf(entry.finding, silences_.contains(entry.id)), &each);
  }
  // Alerts of the same rank stay in the order of their keys.
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  ranked_.clear();
  places_.clear();
  for (const auto& [rank, begun] : order) {
    places_[begun->second.id] = ranked_.size();
    ranked_.push_back(AlertOf(begun->first, begun->second));
  }
}

const Alert* AlertBoard::Find(const std::string& id) const {
  const auto found = places_.find(id);
  return found == places_.end() ? nullptr : &ranked_[found->second];
}

AlertCounts AlertBoard::Counts() const {
  AlertCounts counts;
  for (const Alert& alert : ranked_)
    ++(alert.silence ? counts.silenced : counts.announced)[static_cast<size_t>(alert.key.rule)];
  return counts;
}

absl::Status AlertBoard::Add(Silence silence, int64_t now_ns) {
  if (!silences_.contains(silence.id) && silences_.size() >= kMaxSilences) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the daemon has ", kMaxSilences, " silences; end one first"));
  }
  Kept& kept = silences_[silence.id];
  kept = {.silence = std::move(silence), .last_needed_ns = now_ns};
  silences_changed_ = true;
  Rank();
  return absl::OkStatus();
}

bool AlertBoard::Unsilence(const std::string& id) {
  const auto found = silences_.find(id);
  if (found == silences_.end()) return false;
  RemoveSilence(found);
  Rank();
  return true;
}

bool AlertBoard::TakeSilencesChanged() { return std::exchange(silences_changed_, false); }

std::string AlertBoard::SilencesText() const {
  nlohmann::json silences = nlohmann::json::array();
  for (const auto& [id, kept] : silences_) {
    silences.push_back({{"id", id},
                        {"unix_until_ms", kept.silence.unix_until_ms},
                        {"comment", kept.silence.comment},
                        {"silenced_by", kept.silence.silenced_by}});
  }
  return nlohmann::json{{"version", kSilencesVersion}, {"silences", std::move(silences)}}.dump(
             1, ' ', false, nlohmann::json::error_handler_t::replace) +
         "\n";
}

absl::Status AlertBoard::Restore(const std::string& text, int64_t now_ns, int64_t unix_now_ms) {
  std::map<std::string, Kept> silences;
  try {
    const nlohmann::json file = nlohmann::json::parse(text);
    if (file.at("version") != kSilencesVersion) return absl::DataLossError("unknown version");
    for (const nlohmann::json& each : file.at("silences")) {
      Silence silence = {.id = each.at("id"),
                         .unix_until_ms = each.at("unix_until_ms"),
                         .comment = each.at("comment"),
                         .silenced_by = each.at("silenced_by")};
      if (HasEnded(silence, unix_now_ms) || silences.size() >= kMaxSilences) continue;
      const std::string id = silence.id;
      silences[id] = {.silence = std::move(silence), .last_needed_ns = now_ns};
    }
  } catch (const nlohmann::json::exception& error) {
    return absl::DataLossError(error.what());
  }
  silences_ = std::move(silences);
  Rank();
  return absl::OkStatus();
}

}  // namespace sweepstake::alerts
