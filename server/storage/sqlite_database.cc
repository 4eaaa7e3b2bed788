#include "server/storage/sqlite_database.h"

#include <algorithm>
#include <array>
#include <bit>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/math/hash.h"

namespace sweepstake::storage {
namespace {

absl::Status ToStatus(int code, const char* message) {
  switch (code & 0xff) {
    case SQLITE_FULL:
      return absl::UnavailableError(
          absl::StrCat("the disk is full, or the file has its maximum size: ", message));
    case SQLITE_READONLY:
    case SQLITE_IOERR:
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_NOMEM:
      return absl::UnavailableError(message);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::DataLossError(message);
    case SQLITE_INTERRUPT:
      return absl::CancelledError(message);
    case SQLITE_CONSTRAINT:
    case SQLITE_TOOBIG:
      return absl::InvalidArgumentError(message);
    default:
      return absl::InternalError(message);
  }
}

constexpr int kPagesPerStep = 4096;
constexpr int kInstructionsPerLook = 100'000;

uint64_t HashOf(uint64_t hash, uint64_t bits) {
  hash = math::Fnv1aOfWord(hash, static_cast<uint32_t>(bits));
  return math::Fnv1aOfWord(hash, static_cast<uint32_t>(bits >> 32));
}

uint64_t HashOf(uint64_t hash, sqlite3_value* value) {
  const int type = sqlite3_value_type(value);
  hash = math::Fnv1a(hash, static_cast<uint8_t>(type));
  if (type == SQLITE_INTEGER)
    return HashOf(hash, static_cast<uint64_t>(sqlite3_value_int64(value)));
  // SQLite stores -0.0 as 0. Adding 0.0 gives both numbers the same hash.
  if (type == SQLITE_FLOAT)
    return HashOf(hash, std::bit_cast<uint64_t>(sqlite3_value_double(value) + 0.0));
  const auto* text = static_cast<const char*>(sqlite3_value_blob(value));
  const auto size = static_cast<size_t>(sqlite3_value_bytes(value));
  return math::Fnv1a(HashOf(hash, size), std::string_view(text, size));
}

void RowHash(sqlite3_context* context, int count, sqlite3_value** values) {
  uint64_t hash = math::kFnv1aStart;
  for (int i = 0; i < count; ++i) hash = HashOf(hash, values[i]);
  sqlite3_result_int64(context, static_cast<int64_t>(hash));
}

void NextHash(sqlite3_context* context, int /*count*/, sqlite3_value** values) {
  sqlite3_result_int64(context, sqlite3_value_int64(values[0]) ^ sqlite3_value_int64(values[1]) ^
                                    sqlite3_value_int64(values[2]));
}

void OctetLength(sqlite3_context* context, int /*count*/, sqlite3_value** values) {
  sqlite3_result_int64(context, sqlite3_value_bytes(values[0]));
}

int AddFunctions(sqlite3* database) {
  int code = SQLITE_OK;
  const auto add = [&](const char* name, int arguments, auto* function) {
    constexpr int kFlags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;
    if (code == SQLITE_OK)
      code = sqlite3_create_function_v2(database, name, arguments, kFlags, nullptr, function,
                                        nullptr, nullptr, nullptr);
  };
  add("row_hash", /*arguments=*/-1, &RowHash);
  add("next_hash", 3, &NextHash);
  add("octet_length", 1, &OctetLength);
  return code;
}

// Writes the bytes of the file again. After a failed fsync, readers still see bytes that may not be
// on the disk, and a later fsync would report success without writing them.
int WriteAgain(sqlite3_file& file) {
  sqlite3_int64 size = 0;
  int code = file.pMethods->xFileSize(&file, &size);
  std::array<char, 64 * 1024> bytes;
  for (sqlite3_int64 offset = 0; code == SQLITE_OK && offset < size;) {
    const auto count = static_cast<int>(std::min<sqlite3_int64>(bytes.size(), size - offset));
    code = file.pMethods->xRead(&file, bytes.data(), count, offset);
    if (code == SQLITE_OK) code = file.pMethods->xWrite(&file, bytes.data(), count, offset);
    offset += count;
  }
  return code;
}

class SqliteRow final : public SqlRow {
 public:
  explicit SqliteRow(sqlite3_stmt* statement) : statement_(statement) {}

  int64_t Integer(int column) const override { return sqlite3_column_int64(statement_, column); }
  bool Boolean(int column) const override { return Integer(column) != 0; }
  double Amount(int column) const override { return sqlite3_column_double(statement_, column); }
  uint64_t Count(int column) const override { return Unsigned(column); }
  std::string Text(int column) const override {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    if (text == nullptr) return {};
    return {text, static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
  }
  std::string Bytes(int column) const override {
    const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
    if (bytes == nullptr) return {};
    return {bytes, static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
  }

 private:
  sqlite3_stmt* statement_;
};

void Bind(sqlite3_stmt* statement, int index, const SqlValue& value) {
  const auto bind_text = [&](std::string_view text) {
    // SQLite would bind NULL for the null pointer of an empty view.
    const char* begin = text.empty() ? "" : text.data();
    sqlite3_bind_text64(statement, index, begin, text.size(), SQLITE_STATIC, SQLITE_UTF8);
  };
  if (const auto* integer = std::get_if<int64_t>(&value)) {
    sqlite3_bind_int64(statement, index, *integer);
  } else if (const auto* boolean = std::get_if<bool>(&value)) {
    sqlite3_bind_int64(statement, index, *boolean ? 1 : 0);
  } else if (const auto* amount = std::get_if<SqlAmount>(&value)) {
    sqlite3_bind_double(statement, index, amount->value);
  } else if (const auto* bytes = std::get_if<SqlBytes>(&value)) {
    sqlite3_bind_blob64(statement, index, bytes->value.data(), bytes->value.size(), SQLITE_STATIC);
  } else {
    bind_text(std::get<std::string_view>(value));
  }
}

}  // namespace

absl::Status Explain(const std::filesystem::path& path, const absl::Status& status) {
  return {status.code(), absl::StrCat(path.string(), ": ", status.message())};
}

// The methods of an open file, with a timer around xSync.
struct SqliteDatabase::TimedFile {
  sqlite3_io_methods methods{};  // the first member, so that Sync can cast its address to TimedFile
  const sqlite3_io_methods* untimed = nullptr;
  OnSync on_sync;

  static int Sync(sqlite3_file* file, int flags) {
    const auto* timed = reinterpret_cast<const TimedFile*>(file->pMethods);
    const auto start = std::chrono::steady_clock::now();
    const int code = timed->untimed->xSync(file, flags);
    timed->on_sync(std::chrono::steady_clock::now() - start);
    return code;
  }
};

SqliteDatabase::SqliteDatabase(sqlite3* database) : database_(database) {}
SqliteDatabase::~SqliteDatabase() = default;
SqliteDatabase::SqliteDatabase(SqliteDatabase&&) noexcept = default;

absl::StatusOr<SqliteDatabase> SqliteDatabase::Open(const std::string& path, OpenMode mode) {
  int flags = SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  flags |= mode == OpenMode::kReadOnly ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE;
  if (mode == OpenMode::kCreate) flags |= SQLITE_OPEN_CREATE;
  sqlite3* handle = nullptr;
  int code = sqlite3_open_v2(path.c_str(), &handle, flags, nullptr);
  SqliteDatabase database(handle);
  if (code == SQLITE_OK) code = AddFunctions(handle);
  if (code != SQLITE_OK) return absl::Status(ToStatus(code, sqlite3_errmsg(handle)));
  return database;
}

absl::Status SqliteDatabase::Error(int code) const {
  return ToStatus(code, sqlite3_errmsg(database_.get()));
}

absl::Status SqliteDatabase::Configure() {
  return Execute(R"sql(
    PRAGMA busy_timeout = 2000;
    PRAGMA foreign_keys = ON;
    PRAGMA trusted_schema = OFF;
    PRAGMA cell_size_check = ON;
    PRAGMA synchronous = FULL;
  )sql");
}

absl::StatusOr<SqliteDatabase::Statement> SqliteDatabase::Prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v3(database_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (code != SQLITE_OK) return Error(code);
  return Statement(statement);
}

absl::Status SqliteDatabase::Step(sqlite3_stmt* statement, std::span<const SqlValue> values,
                                  OnRow on_row) {
  for (size_t i = 0; i < values.size(); ++i) Bind(statement, static_cast<int>(i) + 1, values[i]);
  const SqliteRow row(statement);
  int code = SQLITE_ROW;
  while ((code = sqlite3_step(statement)) == SQLITE_ROW) on_row(row);
  absl::Status status = code == SQLITE_DONE ? absl::OkStatus() : Error(code);
  sqlite3_reset(statement);  // releases the read snapshot
  sqlite3_clear_bindings(statement);
  return status;
}

absl::Status SqliteDatabase::Execute(const std::string& sql) {
  const int code = sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : Error(code);
}

absl::StatusOr<int64_t> SqliteDatabase::QueryInteger(std::string_view sql) {
  const auto statement = Prepare(sql);
  if (!statement.ok()) return statement.status();
  int64_t value = 0;
  absl::Status status =
      Step(statement->get(), {}, [&](const SqlRow& row) { value = row.Integer(0); });
  if (!status.ok()) return status;
  return value;
}

absl::StatusOr<std::string> SqliteDatabase::QueryText(std::string_view sql) {
  const auto statement = Prepare(sql);
  if (!statement.ok()) return statement.status();
  std::string value;
  absl::Status status = Step(statement->get(), {}, [&](const SqlRow& row) { value = row.Text(0); });
  if (!status.ok()) return status;
  return value;
}

absl::Status SqliteDatabase::CopyPagesTo(SqliteDatabase& copy) {
  sqlite3_backup* backup =
      sqlite3_backup_init(copy.database_.get(), "main", database_.get(), "main");
  if (backup == nullptr) return copy.Error(sqlite3_errcode(copy.database_.get()));
  // A read transaction makes all steps see one state. Otherwise a commit between two steps would
  // restart the copy.
  absl::Status status = Execute("BEGIN; SELECT count(*) FROM sqlite_schema");
  int code = status.ok() ? SQLITE_OK : SQLITE_ABORT;
  while (code == SQLITE_OK && !stopped()) code = sqlite3_backup_step(backup, kPagesPerStep);
  const int error = sqlite3_backup_finish(backup);
  if (in_transaction()) Execute("COMMIT").IgnoreError();
  if (!status.ok()) return status;
  if (error != SQLITE_OK) return copy.Error(error);
  if (code != SQLITE_DONE) return absl::CancelledError("the copy was cancelled");
  // Leaves WAL mode, because a file in WAL mode cannot be read on a read-only file system.
  return copy.QueryText("PRAGMA journal_mode = DELETE").status();
}

absl::Status SqliteDatabase::CopyTo(const std::string& path, const Edit& edit) {
  const std::string unfinished = path + ".new";
  absl::Status status = CreatePrivateFile(unfinished);
  if (!status.ok()) return status;
  {
    auto copy = Open(unfinished, OpenMode::kExisting);
    status = copy.ok() ? CopyPagesTo(*copy) : copy.status();
    if (status.ok() && edit) status = edit(*copy);
  }
  if (status.ok()) return PublishFile(unfinished, path);
  std::error_code ignored;
  std::filesystem::remove(unfinished, ignored);
  return Explain(unfinished, status);
}

void SqliteDatabase::StopWhen(const std::atomic<bool>* flag) {
  SqlDatabase::StopWhen(flag);
  const auto is_set = [](void* of) {
    return static_cast<const std::atomic<bool>*>(of)->load() ? 1 : 0;
  };
  sqlite3_progress_handler(database_.get(), kInstructionsPerLook,
                           flag != nullptr ? +is_set : nullptr,
                           const_cast<std::atomic<bool>*>(flag));
}

absl::Status SqliteDatabase::LimitSize(uint64_t max_bytes) {
  const auto page_bytes = QueryInteger("PRAGMA page_size");
  if (!page_bytes.ok()) return page_bytes.status();
  const uint64_t pages = max_bytes / static_cast<uint64_t>(*page_bytes);
  // `max_page_count = 0` would only return the limit and not set it.
  return QueryInteger(absl::StrCat("PRAGMA max_page_count = ", std::max<uint64_t>(pages, 1)))
      .status();
}

absl::StatusOr<uint64_t> SqliteDatabase::UsedBytes() {
  const auto page_bytes = QueryInteger("PRAGMA page_size");
  if (!page_bytes.ok()) return page_bytes.status();
  const auto pages = QueryInteger("PRAGMA page_count");
  if (!pages.ok()) return pages.status();
  const auto free_pages = QueryInteger("PRAGMA freelist_count");
  if (!free_pages.ok()) return free_pages.status();
  return static_cast<uint64_t>((*pages - *free_pages) * *page_bytes);
}

absl::Status SqliteDatabase::EnableDefensive() {
  const int code = sqlite3_db_config(database_.get(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : Error(code);
}

absl::StatusOr<sqlite3_file*> SqliteDatabase::LogFile() {
  sqlite3_file* log = nullptr;
  const int code =
      sqlite3_file_control(database_.get(), "main", SQLITE_FCNTL_JOURNAL_POINTER, &log);
  if (code != SQLITE_OK) return Error(code);
  return log;
}

absl::Status SqliteDatabase::SyncLog() {
  // The transaction keeps other connections from writing to the write-ahead log.
  return InTransaction(*this, [&] {
    const auto log = LogFile();
    if (!log.ok()) return log.status();
    int code = WriteAgain(**log);
    if (code == SQLITE_OK) code = (*log)->pMethods->xSync(*log, SQLITE_SYNC_FULL);
    return code == SQLITE_OK ? absl::OkStatus() : ToStatus(code, "cannot sync the write-ahead log");
  });
}

absl::Status SqliteDatabase::TimeSyncs(OnSync on_sync) {
  auto opened = LogFile();
  if (!opened.ok()) return opened.status();
  sqlite3_file* log = *opened;
  timed_log_ = std::make_unique<TimedFile>();
  timed_log_->methods = *log->pMethods;
  timed_log_->methods.xSync = &TimedFile::Sync;
  timed_log_->untimed = log->pMethods;
  timed_log_->on_sync = std::move(on_sync);
  log->pMethods = &timed_log_->methods;
  return absl::OkStatus();
}

absl::Status SqliteDatabase::SetPlace(const std::filesystem::path& path) {
  absl::Status status = files_.Add(path, /*may_shrink=*/false);
  return status.ok() ? files_.Add(path.string() + "-wal", /*may_shrink=*/true) : status;
}

absl::Status SqliteDatabase::Begin() {
  const absl::Status place = CheckPlace();
  return place.ok() ? Execute("BEGIN IMMEDIATE") : absl::UnavailableError(place.message());
}

void SqliteDatabase::Rollback() {
  if (in_transaction()) Execute("ROLLBACK").IgnoreError();
}

absl::StatusOr<uint64_t> SqliteDatabase::RunRows(const char* sql, std::span<const SqlValue> values,
                                                 size_t columns, OnRow on_row) {
  auto found = statements_.find(sql);
  if (found == statements_.end()) {
    auto statement = Prepare(SqliteText(sql));
    if (!statement.ok()) return statement.status();
    found = statements_.emplace(sql, *std::move(statement)).first;
  }
  sqlite3_stmt* const statement = found->second.get();
  if (statement == nullptr) return uint64_t{0};  // the text is for PostgreSQL alone
  uint64_t changed = 0;
  do {
    if (stopped()) return absl::CancelledError("the statement was stopped");
    const auto row = values.first(columns);
    values = values.subspan(columns);
    if (absl::Status status = Step(statement, row, on_row); !status.ok()) return status;
    changed += static_cast<uint64_t>(sqlite3_changes(database_.get()));
  } while (!values.empty());
  return changed;
}

}  // namespace sweepstake::storage
