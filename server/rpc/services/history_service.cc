#include "server/rpc/services/history_service.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "server/history/history.h"
#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {
namespace {

using history::SeriesKey;

constexpr uint32_t kDefaultPoints = 300;
constexpr uint32_t kMaxPoints = 10'000;

// A token has the names of a series, separated by line ends, which names do not contain.
std::string SeriesTokenOf(const SeriesKey& key) {
  return absl::StrJoin({key.scene.project, key.scene.scene, key.scene.machine_class,
                        std::to_string(key.scene.reward_version), key.build, key.session},
                       "\n");
}

std::optional<SeriesKey> SeriesOf(const std::string& token) {
  const std::vector<std::string> names = absl::StrSplit(token, '\n');
  SeriesKey key;
  if (names.size() != 6 || !absl::SimpleAtoi(names[3], &key.scene.reward_version))
    return std::nullopt;
  key.scene.project = names[0];
  key.scene.scene = names[1];
  key.scene.machine_class = names[2];
  key.build = names[4];
  key.session = names[5];
  return key;
}

absl::StatusOr<history::HistoryQuery> QueryOf(const Caller& caller,
                                              const v1::GetHistoryRequest& request) {
  const auto invalid = [](absl::string_view message) {
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE, message);
  };
  history::HistoryQuery query;
  query.kind = request.kind();
  if (query.kind < v1::HISTORY_KIND_SCENE || query.kind > v1::HISTORY_KIND_SESSION)
    return invalid("kind is absent or unknown; set HISTORY_KIND_SCENE, _BUILD or _SESSION");
  query.filter = {request.project(), request.scene()};
  if (absl::Status allowed = Narrow(caller, query.filter); !allowed.ok()) return allowed;
  query.session = request.session_id();
  query.reward_version = request.reward_version();
  query.machine_class = request.machine_class();
  query.from_ms = request.from_unix_ms();
  query.until_ms = request.until_unix_ms();
  const bool is_reversed = query.until_ms != 0 && query.until_ms <= query.from_ms;
  if (query.from_ms < 0 || query.until_ms < 0 || is_reversed)
    return invalid("until_unix_ms must be later than from_unix_ms, and both not negative");
  query.max_points = request.max_points() == 0 ? kDefaultPoints : request.max_points();
  if (query.max_points > kMaxPoints) return invalid("max_points must be at most 10000");
  if (request.page_token().empty()) return query;
  query.after = SeriesOf(request.page_token());
  if (!query.after) return invalid("page_token is not a next_page_token of this daemon");
  return query;
}

}  // namespace

void Answer(ServiceContext& context, const Caller& caller, const v1::GetHistoryRequest& request,
            v1::GetHistoryResponse& response, const EndCall& end) {
  auto query = QueryOf(caller, request);
  if (!query.ok()) return end(query.status());
  if (context.options.history == nullptr) return end(absl::OkStatus());
  const bool is_queued = context.options.history->Read(
      *std::move(query), [&response, end](const absl::StatusOr<history::HistoryPage>& page) {
        if (!page.ok())
          return end(StoreFailed({page.status().code(), absl::StrCat("the history cannot be read: ",
                                                                     page.status().message())}));
        for (const v1::HistorySeries& series : page->series) *response.add_series() = series;
        if (page->next) response.set_next_page_token(SeriesTokenOf(*page->next));
        end(absl::OkStatus());
      });
  if (!is_queued)
    end(Refused(v1::ERROR_REASON_STORE_BUSY, "the history is overloaded; try again later"));
}

}  // namespace sweepstake::rpc
