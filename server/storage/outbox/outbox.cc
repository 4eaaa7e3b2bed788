#include "server/storage/outbox/outbox.h"

#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/storage/outbox/update_text.h"
#include "server/storage/private_file.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kVersion = 1;
constexpr const char* kTable = R"sql(
    CREATE TABLE IF NOT EXISTS waiting (
      place INTEGER PRIMARY KEY,
      body TEXT NOT NULL
    ) STRICT;
    PRAGMA user_version = 1)sql";

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
  if (*version > kVersion) return Unreadable(path, "it is of a newer daemon");
  if (status = database->Execute(kTable); !status.ok()) return Explain(path, status);
  return Outbox(path, *std::move(database));
}

absl::Status Outbox::Replace(std::span<const priors::SourceUpdate> updates) {
  SqlTransaction transaction(database_);
  absl::Status status = transaction.begun();
  if (status.ok()) status = database_.Execute("DELETE FROM waiting");
  auto insert = database_.Prepare("INSERT INTO waiting (body) VALUES (?1)");
  if (status.ok()) status = insert.status();
  for (size_t i = 0; i < updates.size() && status.ok(); ++i)
    status = insert->Run(UpdateText(updates[i]));
  if (status.ok()) status = transaction.Commit();
  return status.ok() ? status : Explain(path_, status);
}

absl::StatusOr<std::vector<priors::SourceUpdate>> Outbox::Load() {
  auto select = database_.Prepare("SELECT body FROM waiting ORDER BY place");
  if (!select.ok()) return Explain(path_, select.status());
  std::vector<priors::SourceUpdate> updates;
  absl::Status damage;
  absl::Status status = select->ForEachRow([&](const SqliteRow& row) {
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
  return absl::FailedPreconditionError(absl::StrCat(
      path.string(), " has ", updates->size(),
      " updates that the shared store lacks: start the daemon with `store` once more, which "
      "delivers them, or move the file away"));
}

}  // namespace sweepstake::storage
