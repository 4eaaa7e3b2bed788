#include "server/storage/backup/automatic_backup.h"

#include <sys/stat.h>

#include <algorithm>
#include <ctime>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/sessions/common/unix_time.h"
#include "server/storage/backup/kept_files.h"
#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/commit_mark.h"
#include "server/storage/private_file.h"
#include "server/storage/sqlite_prior_store.h"
#include "server/storage/sqlite_schema.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

constexpr absl::string_view kBackup = ".backup-";
constexpr absl::string_view kQuarantine = ".quarantine-";
constexpr size_t kMaxQuarantined = 2;

// Returns the time (UTC) as text.
std::string TimeText() {
  const std::time_t now = priors::UnixNowS();
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::string text(16, '\0');
  std::strftime(text.data(), text.size() + 1, "%Y%m%dT%H%M%SZ", &utc);
  return text;
}

// Returns the number in the name of a copy; 0 if it has none.
uint64_t NumberOf(const fs::path& copy, absl::string_view kind) {
  const std::string name = copy.filename().string();
  const size_t begin = name.rfind(std::string(kind)) + kind.size();
  uint64_t number = 0;
  return absl::SimpleAtoi(name.substr(begin, name.find('-', begin) - begin), &number) ? number : 0;
}

// Lists the files beside the database whose names consist of its name, `kind` (kBackup or
// kQuarantine), a number, a time and `end`. The newest comes first. `end` includes the Z of the
// time.
std::vector<fs::path> ListCopies(const fs::path& path, absl::string_view kind,
                                 absl::string_view end = "Z") {
  const std::string begin = absl::StrCat(path.filename().string(), kind);
  std::vector<fs::path> copies;
  std::error_code unreadable;
  fs::directory_iterator entry(path.parent_path(), unreadable);
  for (; !unreadable && entry != fs::directory_iterator(); entry.increment(unreadable)) {
    const std::string name = entry->path().filename().string();
    if (absl::StartsWith(name, begin) && absl::EndsWith(name, end)) copies.push_back(entry->path());
  }
  std::sort(copies.begin(), copies.end(), [&](const fs::path& a, const fs::path& b) {
    return std::pair(NumberOf(a, kind), a) > std::pair(NumberOf(b, kind), b);
  });
  return copies;
}

// Returns the name of the next copy.
fs::path NextCopy(const fs::path& path, absl::string_view kind) {
  const std::vector<fs::path> copies = ListCopies(path, kind);
  const uint64_t number = copies.empty() ? 0 : NumberOf(copies.front(), kind);
  return absl::StrCat(path.string(), kind, absl::Dec(number + 1, absl::kZeroPad6), "-", TimeText());
}

void RemoveOldest(const fs::path& path, absl::string_view kind, size_t max) {
  const std::vector<fs::path> copies = ListCopies(path, kind);
  std::error_code ignored;
  for (size_t i = max; i < copies.size(); ++i) {
    for (const char* suffix : {"", "-wal"}) fs::remove(copies[i].string() + suffix, ignored);
  }
}

// Removes the files of backups that were unfinished when a daemon was killed. Their names contain
// the time, so no later backup would overwrite them.
void RemoveUnfinished(const fs::path& path) {
  std::error_code ignored;
  for (const char* end : {"Z.new", "Z.new-journal", "Z.tokens", "Z.tokens.new"}) {
    for (const fs::path& file : ListCopies(path, kBackup, end)) fs::remove(file, ignored);
  }
}

// Returns whether the file is damaged or not a database.
bool IsDamaged(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return false;
  if (fs::file_size(path, error) == 0) return true;
  auto database = SqliteDatabase::Open(path.string(), SqliteDatabase::OpenMode::kExisting);
  return absl::IsDataLoss(database.ok() ? CheckPages(*database, path) : database.status());
}

std::optional<fs::path> LastWholeBackup(const fs::path& path) {
  for (const fs::path& backup : ListCopies(path, kBackup)) {
    if (VerifyStore(backup).ok()) return backup;
  }
  return std::nullopt;
}

// Keeps the file under a second name: by a hard link, or by a copy if the file system has no hard
// links (FAT).
absl::Status Keep(const fs::path& path, const fs::path& kept) {
  std::error_code error;
  fs::create_hard_link(path, kept, error);
  if (!error) return absl::OkStatus();
  const fs::path unfinished = path.string() + ".quarantined";
  if (error != std::errc::file_exists)
    fs::copy_file(path, unfinished, fs::copy_options::overwrite_existing, error);
  if (!error) return PublishFile(unfinished, kept);
  std::error_code ignored;
  fs::remove(unfinished, ignored);
  return absl::UnavailableError(absl::StrCat("cannot keep ", kept.string(), ": ", error.message()));
}

// Keeps the damaged database as `kept`, then renames a copy of the backup to `path`. After a crash
// before the rename, the damaged file is still at `path`, and the next start tries again.
absl::Status Replace(const fs::path& path, const fs::path& backup, const fs::path& kept) {
  const std::string unfinished = path.string() + ".restored";
  auto source = SqliteDatabase::Open(backup.string(), SqliteDatabase::OpenMode::kReadOnly);
  if (!source.ok()) return source.status();
  absl::Status status = source->CopyTo(unfinished, DropKeptFiles);
  if (!status.ok()) return status;
  if (status = Keep(path, kept); !status.ok()) return status;
  std::error_code error;
  // SQLite would replay the write-ahead log of the damaged database onto the backup.
  fs::rename(path.string() + "-wal", kept.string() + "-wal", error);
  if (error && error != std::errc::no_such_file_or_directory)
    return absl::UnavailableError(
        absl::StrCat("cannot keep ", path.string(), "-wal: ", error.message()));
  fs::remove(path.string() + "-shm", error);
  return PublishFile(unfinished, path);
}

// Returns a warning with the number of damaged rows of evidence. Returns an empty text if there are
// none, or if they cannot be counted.
std::string DescribeDamagedRows(const fs::path& path) {
  auto database = SqliteDatabase::Open(path.string(), SqliteDatabase::OpenMode::kExisting);
  if (!database.ok()) return {};
  const auto count = CountDamagedRows(*database);
  if (!count.ok() || *count == 0) return {};
  return absl::StrCat(*count, " rows of ", path.string(),
                      " were changed on the disk. Their scenes have no priors, their sessions are "
                      "not resumed, and exports and comparisons of builds that need them fail. "
                      "Check the disk, and restore a backup");
}

// Adds to the error what an operator can do if there is no usable database.
absl::Status WithAdvice(const absl::Status& problem, const fs::path& path, bool damaged) {
  const std::string name = path.filename().string();
  std::string text(problem.message());
  if (damaged)
    absl::StrAppend(&text, ", and there is no undamaged backup ", name, kBackup, "* beside it");
  absl::StrAppend(&text, "; move away those of ", name, ", ", name, "-wal and ", name,
                  "-shm that exist, then restore a backup with `sweepstaked restore`, or delete ",
                  StoreIdFile(path).string(), " too, to start with an empty store");
  return {problem.code(), text};
}

// Returns a warning if the store has fewer commits than when it was last looked at.
std::string DescribeLostCommits(priors::PriorStore& store, const fs::path& path) {
  const auto count = CountCommits(store);
  const uint64_t marked = CommitMark(path).Read();
  if (!count.ok() || *count >= marked) return {};
  return absl::StrCat(path.string(), " lacks ", marked - *count,
                      " commits that it had before: its write-ahead log was removed, or an older "
                      "copy is in its place. Their evidence is lost unless you stop the daemon and "
                      "put the files back. A backup may have it");
}

absl::StatusOr<OpenedStore> WithReads(std::unique_ptr<priors::PriorStore> store,
                                      const fs::path& path, std::string damage) {
  auto reads = OpenSqliteReadConnection(path);
  if (!reads.ok()) return reads.status();
  const auto file = FileId::Of(path);
  if (!file.ok()) return file.status();
  return OpenedStore{std::move(store), *std::move(reads), std::move(damage), *file};
}

}  // namespace

absl::StatusOr<OpenedStore> OpenStoreOrBackup(const fs::path& path,
                                              const priors::AuditLimits& audit_limits,
                                              uint64_t max_bytes, OnSync on_sync) {
  auto store = OpenSqlitePriorStore(path, audit_limits, max_bytes, on_sync);
  if (store.ok()) {
    std::string damage = DescribeDamagedRows(path);
    const std::string lost = DescribeLostCommits(**store, path);
    absl::StrAppend(&damage, damage.empty() || lost.empty() ? "" : ". ", lost);
    return WithReads(*std::move(store), path, std::move(damage));
  }
  const absl::Status problem = store.status();
  if (!absl::IsDataLoss(problem)) return problem;
  const bool damaged = IsDamaged(path);
  const std::optional<fs::path> backup = damaged ? LastWholeBackup(path) : std::nullopt;
  if (!backup) return WithAdvice(problem, path, damaged);
  const fs::path kept = NextCopy(path, kQuarantine);
  if (absl::Status status = Replace(path, *backup, kept); !status.ok()) return status;
  RemoveOldest(path, kQuarantine, kMaxQuarantined);
  store = OpenSqlitePriorStore(path, audit_limits, max_bytes, std::move(on_sync));
  if (!store.ok()) return store.status();
  return WithReads(
      *std::move(store), path,
      absl::StrCat(problem.message(), ". The damaged file is kept as ", kept.string(), ", and ",
                   backup->filename().string(),
                   " replaces it: what was learnt since that backup is lost. Check the disk"));
}

std::optional<fs::file_time_type> LastBackupTime(const fs::path& path) {
  const std::vector<fs::path> backups = ListCopies(path, kBackup);
  if (backups.empty()) return std::nullopt;
  std::error_code gone;
  const auto time = fs::last_write_time(backups.front(), gone);
  if (gone) return std::nullopt;
  return time;
}

absl::StatusOr<fs::path> SaveMisplacedStore(priors::PriorStore& store, const fs::path& path) {
  mkdir(path.parent_path().c_str(), 0700);  // if this fails, CopyStore returns an error
  const fs::path file = NextCopy(path, kBackup);
  absl::Status status = CopyStore(store, file, [](SqliteDatabase& copy) {
    LeaveOutDamagedRows(copy);
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return file;
}

AutomaticBackups::AutomaticBackups(fs::path path, const BackupPlan& plan, OnDone on_done)
    : path_(std::move(path)),
      plan_(plan),
      on_done_(std::move(on_done)),
      thread_([this] { Loop(); }) {}

AutomaticBackups::~AutomaticBackups() {
  Stop();
  thread_.join();
}

void AutomaticBackups::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
}

void AutomaticBackups::Loop() {
  if (plan_.count == 0) return;
  RemoveUnfinished(path_);
  std::chrono::milliseconds delay = FirstDelay();
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, delay, [this] { return stopping_.load(); })) {
    lock.unlock();
    const auto made = MakeOne();
    if (made.ok()) RemoveOldest(path_, kBackup, plan_.count);
    if (!stopping_) on_done_(made);
    delay = made.ok() ? plan_.interval : std::min(plan_.patience, plan_.interval);
    lock.lock();
  }
}

std::chrono::milliseconds AutomaticBackups::FirstDelay() const {
  const auto last = LastBackupTime(path_);
  if (!last) return std::min(plan_.patience, plan_.interval);
  const auto age = std::chrono::duration_cast<std::chrono::milliseconds>(
      fs::file_time_type::clock::now() - *last);
  return std::clamp(plan_.interval - age, std::chrono::milliseconds(0), plan_.interval);
}

absl::StatusOr<MadeBackup> AutomaticBackups::MakeOne() {
  if (plan_.file != FileId()) {
    const auto now = FileId::Of(path_);
    if (!now.ok()) return now.status();
    if (*now != plan_.file)
      return absl::UnavailableError(
          absl::StrCat(path_.string(), " is not the file that the daemon uses"));
  }
  // Requires free space of twice the file's size: a backup must not fill the disk that new evidence
  // needs.
  std::error_code unknown;
  std::error_code missing;
  const fs::space_info space = fs::space(path_.parent_path(), unknown);
  const uintmax_t bytes = fs::file_size(path_, missing);
  if (!missing && !unknown && space.available / 2 < bytes) {
    return absl::UnavailableError(absl::StrCat(
        "a backup needs ", bytes >> 19,
        " MiB of free space, twice the size of the store; free some, or set backup_count to 0"));
  }
  const fs::path file = NextCopy(path_, kBackup);
  const auto contents = BackUpStore(path_.parent_path(), file, &stopping_);
  if (contents.ok()) return MadeBackup{file, contents->damaged_row_count};
  if (!absl::IsAlreadyExists(contents.status())) fs::remove(file, unknown);
  return contents.status();
}

}  // namespace sweepstake::storage
