#include "server/storage/outbox/outbox.h"

#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/storage/private_file.h"

namespace sweepstake {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(EvidenceKey, project, scene, measured_by, arm, backend_version,
                                   machine_class, reward_version, regime)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Evidence, alpha, beta, window_count, bail_out_count)

}  // namespace sweepstake

namespace sweepstake::priors {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(KeyedEvidence, key, evidence)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceProgress, source_id, commit_sequence, message_sequence,
                                   explored_arm_count, decision_count, frame_count, seed)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StoredAuditRow, number, bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AuditRows, segment, project, scene, unix_start_ms, rows)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceOrigin, build, token_id, player, network)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceWriter, id, resumed_sequence)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceUpdate, progress, unix_time_s, increments, audit, origin,
                                   writer, known, is_of_player)

}  // namespace sweepstake::priors

namespace sweepstake::storage {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int64_t kVersion = 1;
constexpr const char* kTable = R"sql(
    CREATE TABLE IF NOT EXISTS waiting (
      place INTEGER PRIMARY KEY,
      body TEXT NOT NULL
    ) STRICT;
    PRAGMA user_version = 1)sql";

// Returns the update as CBOR bytes, from which UpdateIn restores every bit of its numbers.
std::string BytesOf(const priors::SourceUpdate& update) {
  const auto bytes = json::to_cbor(json(update));
  return {bytes.begin(), bytes.end()};
}

// Error: DATA_LOSS (the bytes are not an update).
absl::StatusOr<priors::SourceUpdate> UpdateIn(const std::string& bytes) {
  try {
    return json::from_cbor(bytes).get<priors::SourceUpdate>();
  } catch (const json::exception& error) {
    return absl::DataLossError(error.what());
  }
}

absl::Status Unreadable(const fs::path& path, absl::string_view why) {
  return absl::DataLossError(absl::StrCat(
      path.string(), ": ", std::string(why),
      "; it has evidence that the shared store lacks: keep a copy, then move it away"));
}

}  // namespace

absl::StatusOr<Outbox> Outbox::Open(const fs::path& path) {
  std::error_code unknown;  // a file that cannot be examined cannot be opened either
  if (!fs::exists(path, unknown)) {
    if (absl::Status status = CreatePrivateFile(path); !status.ok()) return status;
  }
  auto database = SqliteDatabase::Open(path.string(), SqliteDatabase::OpenMode::kExisting);
  if (!database.ok()) return Explain(path, database.status());
  absl::Status status = database->Configure();
  const auto version = status.ok() ? database->QueryInteger("PRAGMA user_version") : status;
  if (absl::IsDataLoss(version.status())) return Unreadable(path, version.status().message());
  if (!version.ok()) return Explain(path, version.status());
  if (*version > kVersion) return Unreadable(path, "a newer version of the daemon wrote it");
  if (status = database->Execute(kTable); !status.ok()) return Explain(path, status);
  return Outbox(path, *std::move(database));
}

absl::Status Outbox::Replace(std::span<const priors::SourceUpdate> updates) {
  const absl::Status status = InTransaction(database_, [&] {
    absl::Status written = database_.Execute("DELETE FROM waiting");
    for (size_t i = 0; i < updates.size() && written.ok(); ++i)
      written = database_.Run("INSERT INTO waiting (body) VALUES (?1)", BytesOf(updates[i]));
    return written;
  });
  return status.ok() ? status : Explain(path_, status);
}

absl::StatusOr<std::vector<priors::SourceUpdate>> Outbox::Load() {
  std::vector<priors::SourceUpdate> updates;
  absl::Status damage;
  absl::Status status =
      database_.ForEachRow("SELECT body FROM waiting ORDER BY place", [&](const SqlRow& row) {
        auto update = UpdateIn(row.Text(0));
        if (update.ok()) {
          updates.push_back(*std::move(update));
        } else {
          damage = update.status();
        }
      });
  if (!status.ok()) return Explain(path_, status);
  if (!damage.ok()) return Unreadable(path_, damage.message());
  return updates;
}

absl::StatusOr<Outbox::Delivery> Outbox::DeliverTo(priors::PriorStore& store) {
  const auto updates = Load();
  if (!updates.ok()) return updates.status();
  Delivery delivery;
  for (const priors::SourceUpdate& update : *updates) {
    const absl::Status status = store.Commit({&update, 1});
    if (!status.ok() && !priors::IsRefusal(status)) return status;
    ++(status.ok() ? delivery.committed_count : delivery.refused_count);
  }
  if (updates->empty()) return delivery;
  if (absl::Status status = Replace({}); !status.ok()) return status;
  return delivery;
}

absl::Status CheckDelivered(const fs::path& path) {
  std::error_code unknown;
  if (!fs::exists(path, unknown)) return absl::OkStatus();
  auto outbox = Outbox::Open(path);
  if (!outbox.ok()) return outbox.status();
  const auto updates = outbox->Load();
  if (!updates.ok() || updates->empty()) return updates.status();
  return absl::FailedPreconditionError(
      absl::StrCat(path.string(), " has ", updates->size(),
                   " updates that the shared store lacks: start the daemon once with `store`, "
                   "which delivers them, or move the file away"));
}

}  // namespace sweepstake::storage
