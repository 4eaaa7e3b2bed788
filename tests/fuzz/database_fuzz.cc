// Fuzzes a database: arbitrary bytes are opened, read and written, or refused. The input is the
// file itself, or changes to a valid file, because few other inputs pass SQLite's own checks.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/record_limits.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/fuzz/input.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;
using fuzz::Input;
using fuzz::Require;
using priors::PriorRecord;
using priors::PriorStore;
using priors::SourceUpdate;

constexpr uint32_t kPage = 100;
constexpr uint64_t kNowS = 1'700'000'000;

SourceUpdate Update(const std::string& source, uint64_t sequence) {
  SourceUpdate update;
  update.progress.source_id = source;
  update.progress.commit_sequence = sequence;
  update.progress.message_sequence = sequence;
  update.unix_time_s = kNowS;
  for (const char* arm : {"Grid", "KDTree", "SAP"}) {
    priors::KeyedEvidence increment{{"game", "harbour", "", arm, 1, "desktop", 1}, {}};
    increment.evidence = {1.5, 2.5, 3, 1};
    update.increments.push_back(increment);
  }
  update.audit.project = "game";
  update.audit.scene = "harbour";
  update.audit.rows = {{sequence, "a row"}};
  return update;
}

fs::path Folder() {
  static const test_support::TemporaryDirectory kFolder;
  return kFolder.path();
}

void RemoveDatabase() {
  for (const auto& entry : fs::directory_iterator(Folder())) fs::remove(entry.path());
}

// Returns the bytes of a database with something in every table.
std::string ValidDatabase() {
  const fs::path path = Folder() / "priors.db";
  {
    auto store = OpenSqlitePriorStore(path);
    Require(store.ok(), "a store can be created");
    Require((*store)->Commit(std::vector{Update("a", 1), Update("b", 1)}).ok(), "committed");
    const PriorRecord imported{Update("", 1).increments[0].key, "c", 1, {1, 1, 1, 0}};
    Require((*store)->Import({&imported, 1}).ok(), "imported");
    Require((*store)->Revoke({.id = "b"}, false).ok(), "revoked");
    const PriorRecord waiting{Update("", 1).increments[0].key, "e", 1, {1, 1, 1, 0}};
    Require((*store)->Quarantine({&waiting, 1}, kPage).ok(), "set aside");
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  file.close();
  RemoveDatabase();
  return bytes;
}

// Returns the bytes after changes: pieces are overwritten, cut off or appended.
std::string Changed(std::string bytes, Input input) {
  while (!input.empty()) {
    const uint8_t change = input.Byte();
    const size_t offset = (input.TwoBytes() << 4 | change % 16) % (bytes.size() + 1);
    const std::string_view piece = input.Piece();
    if (change >= 0xf0) {
      bytes.resize(offset);
      bytes.append(piece);
    } else {
      bytes.replace(offset, std::min(piece.size(), bytes.size() - offset), piece);
    }
  }
  return bytes;
}

// Reads everything in a store. The results must be valid, or the store must report an error.
void Read(PriorStore& store) {
  if (const auto records = store.Export({}, {}, kPage); records.ok())
    Require(CheckRecords(records->records).ok(), "evidence that was read is valid");
  if (const auto records = store.ExportQuarantined({}, {}, kPage); records.ok())
    Require(CheckRecords(records->records).ok(), "quarantined evidence is valid");
  if (const auto scenes = store.List({}, std::nullopt, kPage); scenes.ok()) {
    for (const auto& scene : *scenes) {
      (void)store.LoadScene(scene.key);
      (void)store.LoadSources(scene.key);
    }
  }
  (void)store.LoadSource("a");
  (void)store.LoadSource("c");
  (void)store.CountScenes("game");
  (void)store.CountProjects();
  if (const auto segments = store.ListAudit({}, 0, kPage); segments.ok()) {
    for (const auto& segment : *segments) (void)store.LoadAudit(segment.id, 1, kPage, 1 << 16);
  }
  (void)store.ScanAudit({}, priors::AuditOrder::kNewestFirst, 0, kPage);
}

void Write(PriorStore& store) {
  const SourceUpdate update = Update("a", 2);
  (void)store.Commit({&update, 1});
  const PriorRecord record{update.increments[0].key, "d", 1, {1, 1, 1, 0}};
  (void)store.Import({&record, 1});
  (void)store.Quarantine({&record, 1}, kPage);
  (void)store.Promote({}, false);
  (void)store.Revoke({.id = "c"}, false);
}

void Run(Input input) {
  static const std::string kValid = ValidDatabase();
  const bool is_file = input.Byte() == 'f';
  const fs::path path = Folder() / "priors.db";
  {
    const std::string bytes = is_file ? std::string(input.Rest()) : Changed(kValid, input);
    std::ofstream(path, std::ios::binary) << bytes;
  }
  (void)VerifyStore(path);
  if (auto store = OpenSqlitePriorStore(path); store.ok()) {
    Read(**store);
    Write(**store);
    Read(**store);
  } else {
    Require(!store.status().message().empty(), "a refusal says why");
  }
  RemoveDatabase();
}

}  // namespace
}  // namespace sweepstake::storage

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  sweepstake::storage::Run({data, size});
  return 0;
}
